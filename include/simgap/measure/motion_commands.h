/// \file
/// What muscles are told over time, and the table that says so.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/measure/pose_set.h"

namespace simgap {

/// What a muscle's command is: the reference of a controller, or the motor's voltage itself.
enum class CommandKind {
  kSetpoint,  ///< of the shaft [rad]
  kVoltage,   ///< [V]
  kForce,     ///< of the line [N]
};
struct CommandColumn {
  std::string_view stem, unit;  ///< "setpoint", "rad": the column is setpoint_<muscle>_rad
};
CommandColumn columnOf(CommandKind kind);

/// Commands of all muscles, and of the lines that take one, at rising times. Before the first row its values hold,
/// behind the last row its own.
struct MotionCommands {
  std::vector<CommandKind> kinds;  ///< shape (muscles)
  std::vector<double> times;       ///< shape (rows) [s]
  Eigen::MatrixXd values;          ///< shape (muscles + lines, rows)
  bool linear = false;             ///< between rows; else a row holds until the next

  /// The values at a time. \param[in,out] row  where the search begins: the row of the call before, or 0
  /// \param[out] values  shape (muscles + lines), or the first of them
  void at(double time, std::size_t& row, std::span<double> values) const;
  double end() const { return times.back(); }  ///< [s]
};

/// The column `time_s`, rising. \throws DataError
std::vector<double> readRisingTimes(const CsvTable& table);

/// A column of a muscle that the model does not have belongs to another arm, or is misspelt.
/// \param stems  "setpoint", …: what stands before the muscle's name  \throws DataError
void refuseForeignMuscles(const CsvTable& table, const PoseLayout& layout, std::span<const std::string_view> stems);

/// Reads `time_s`, per muscle setpoint_<m>_rad, voltage_<m>_V or force_<m>_N, and the commands of the layout's lines.
/// Other columns are left alone.
/// \throws DataError: no rows, times that do not rise, a muscle without a command or with two, a line without one, a
/// command for a muscle that the layout does not have, and all that CsvTable refuses.
MotionCommands readCommands(const CsvTable& table, const PoseLayout& layout, bool linear);

/// The table that readCommands reads.
std::string commandsCsv(const MotionCommands& commands, const PoseLayout& layout);

}  // namespace simgap
