/// \file
/// What muscles are told over time.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/model/arm/arm.h"

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

/// What a muscle cannot be told: a voltage beyond its supply, a force that pushes; empty when it can.
std::string problemOf(const Muscle& muscle, CommandKind kind, double value);

/// Commands of all muscles at rising times. Before the first row its values hold, behind the last row its own.
struct MotionCommands {
  std::vector<CommandKind> kinds;  ///< shape (muscles)
  std::vector<double> times;       ///< shape (rows) [s]
  Eigen::MatrixXd values;          ///< shape (muscles, rows)
  bool linear = false;             ///< between rows; else a row holds until the next

  /// The values at a time. \param[in,out] row  where the search begins: the row of the call before, or 0
  /// \param[out] values  shape (muscles)
  void at(double time, std::size_t& row, std::span<double> values) const;
  double end() const { return times.back(); }  ///< [s]
};

/// `time_s` of a table. \throws DataError: times that do not rise, and all that CsvTable refuses
std::vector<double> readRisingTimes(const CsvTable& table);

/// Reads `time_s` and per muscle setpoint_<m>_rad, voltage_<m>_V or force_<m>_N. Columns of sensors are left
/// alone.
/// \throws DataError: no rows, times that do not rise, a muscle without a command or with two, a command for a muscle
/// that the model does not have, a voltage beyond the supply, a force below 0, and all that CsvTable refuses.
MotionCommands readCommands(const CsvTable& table, const ArmModel& model, bool linear);

}  // namespace simgap
