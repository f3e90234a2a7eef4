/// \file
/// What a motion is told besides its commands: where it begins, and when it ends.
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

/// When commands end. \param duration  [s] instead of the last command's time
/// \throws DataError: the only command's time is the start, and no duration says how long it is held
double motionEnd(const MotionCommands& commands, const std::string& file, const std::optional<double>& duration);

}  // namespace simgap
