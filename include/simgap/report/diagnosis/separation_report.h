/// \file
/// The result of `design --separate` as JSON (docs/formats.md), tables and text.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/intervene/logs/log_intervention.h"
#include "simgap/intervene/motions/motion_separation.h"
#include "simgap/intervene/poses/pose_separation.h"

namespace simgap {

Json toJson(const PoseSeparation& result, const PoseEvidence& evidence);
/// The commands, ready for the rig: pose, shaft_<muscle>_rad, and where the named model expects the joints.
std::string nextPosesCsv(const PoseSeparation& result, const ArmModel& model);

/// One way to run the reference log again.
struct LogProtocol {
  double speed = 1.0, load = 1.0;  ///< factors
  ForeseenLogChange foreseen;
  std::string beyond = {};  ///< which limit it exceeds, and by what: "41.3 A"
};
/// Which of the limits on current and duration the named model's prediction exceeds, and by what; empty when none.
/// \throws ConfigError: a limit on the current of a log whose effort is none
std::string beyondLimits(const ForeseenLogChange& foreseen, const MotionLimits& limits);
/// \param protocols  not empty
Json toJson(const std::vector<LogProtocol>& protocols, const LogEvidence& evidence);
/// The one within the limits that tells most. \throws ConfigError: none is
const LogProtocol& bestOf(const std::vector<LogProtocol>& protocols);

Json toJson(const MotionSeparation& result, const MotionEvidence& evidence);
/// "next_1.csv": of a motion's place among those to record.
std::string nextMotionFile(int chosen);

/// Of any of these results.
std::string separationText(const Json& result);

}  // namespace simgap
