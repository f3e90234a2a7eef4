/// \file
/// What a motion is told besides its commands: where it begins, when it ends, and what was recorded of it.
#pragma once

#include <optional>
#include <string>

#include "simgap/simulate/motion_schedule.h"
#include "simgap/simulate/possible_commands.h"
#include "simgap/simulate/rollout.h"

namespace simgap {

/// A row of a table that holds `shaft_<muscle>_rad` and the joints' positions (a pose set, motion.csv) as a start at
/// rest. \param pose  of the column `pose`; empty: the first row
/// \throws DataError: no such pose, a missing column, a cell that is no position
MotionStart readMotionStart(const CsvTable& table, const ArmModel& model, const std::string& pose);

/// A recorded movement of the joints, and the simulated one at the same times.
struct MeasuredMotion {
  std::string file;
  std::vector<double> times;          ///< shape (rows) [s]
  std::vector<JointPosition> joints;  ///< shape (rows, joints)
  MotionTrack simulated;
};
/// Rows of a table of joints between two times. \throws DataError: none of them, or what CsvTable refuses
MeasuredMotion readMeasuredJoints(const CsvTable& table, const ArmModel& model, double start, double end);

/// When commands end. \param duration  [s] instead of the last command's time
/// \throws DataError: the only command's time is the start, and no duration says how long it is held
double motionEnd(const MotionCommands& commands, const std::string& file, const std::optional<double>& duration);

}  // namespace simgap
