/// \file
/// Recorded motions of an arm: the commands of its muscles over time and what was measured meanwhile
/// (docs/formats.md, "Motion sets").
#pragma once

#include <filesystem>
#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "simgap/core/rotation.h"
#include "simgap/core/yaml.h"
#include "simgap/measure/motion_commands.h"
#include "simgap/measure/pose_set.h"

namespace simgap {

/// What was measured of one muscle over the rows of a muscles file. A channel that is not there is empty.
struct MuscleRecord {
  std::vector<double> shafts;    ///< shape (rows) [rad]
  std::vector<double> currents;  ///< shape (rows) [A]
  std::vector<double> forces;    ///< shape (rows) [N]
};

/// A measured state.
struct RecordedStart {
  std::vector<JointPosition> joints;                   ///< shape (joints)
  std::vector<double> shafts;                          ///< shape (muscles) [rad]
  std::vector<Eigen::Vector3d> joint_velocities = {};  ///< shape (joints), a ball's in the child's frame; empty: rest
};

/// One motion. Muscles and joints have clocks of their own.
struct RecordedMotion {
  std::string name;
  MotionCommands commands;                         ///< shape (muscles and lines of the layout, rows)
  std::vector<MuscleRecord> muscles;               ///< shape (muscles of the layout)
  std::vector<double> joint_times;                 ///< shape (frames) [s], rising
  std::vector<std::vector<JointPosition>> joints;  ///< shape (frames, joints of the layout)
  std::optional<RecordedStart> start;              ///< empty: at rest under the first commands
  double weight = 1.0;                             ///< in a fit, > 0
  /// Before it the motion is played, but not compared: a run-up from a measured state [s].
  double compared_from = -std::numeric_limits<double>::infinity();
  std::filesystem::path muscles_file, joints_file;  ///< as they were read

  const std::vector<double>& times() const { return commands.times; }   ///< shape (rows) [s], rising
  double duration() const { return times().back() - times().front(); }  ///< [s]
};

struct MotionSet {
  std::string file;
  std::vector<RecordedMotion> motions;
  std::vector<std::string> notes = {};  ///< what was done to them as they were read
};

/// When the first command changes; the end, if none does [s].
double firstChange(const RecordedMotion& motion);

/// Reads the table of a file that a motion set names.
using TableReader = std::function<CsvTable(const std::filesystem::path& file)>;

/// Reads a motion set, `simgap/motions/1`; its files stand beside it.
/// \throws ConfigError: the set itself; DataError: a muscle without a command or a column of a muscle that the model
///         does not have, times that do not rise, clocks that do not overlap, a motion that is said to start at rest
///         and moves, joints of another kind, and all that CsvTable refuses.
MotionSet readMotionSet(const YamlNode& root, const std::filesystem::path& file, const PoseLayout& layout,
                        const TableReader& table);

}  // namespace simgap
