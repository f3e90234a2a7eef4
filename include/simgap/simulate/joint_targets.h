/// \file
/// Where an arm's joints are to be over time.
#pragma once

#include <vector>

#include "simgap/core/csv.h"
#include "simgap/measure/motion_commands.h"
#include "simgap/model/arm/arm.h"

namespace simgap {

/// Before the first row its positions hold, behind the last row its own; between rows they move evenly when `linear`,
/// else a row holds until the next.
struct JointTargets {
  std::vector<double> times;          ///< shape (rows) [s], rising
  std::vector<JointPosition> joints;  ///< shape (rows, joints)
  bool linear = false;

  /// \param[out] positions  shape (joints)
  void at(double time, const std::vector<Joint>& kinds, std::vector<JointPosition>& positions) const;
};

/// Whether a table commands joints: it has a column `target_…`.
bool hasJointTargets(const CsvTable& table, const ArmModel& model);
/// Reads `time_s` and per joint what a table of joints has, with `target_` before it: target_elbow_rad,
/// target_shoulder_qw, … \throws DataError: no rows, times that do not rise, a joint without its columns, a muscle's
/// command beside them
JointTargets readJointTargets(const CsvTable& table, const ArmModel& model, bool linear);

/// The commands that such a movement is played with: forces of all muscles, which JointPositionController makes at the
/// ticks. Times are the targets'.
MotionCommands commandsFor(const JointTargets& targets, std::size_t muscles);

}  // namespace simgap
