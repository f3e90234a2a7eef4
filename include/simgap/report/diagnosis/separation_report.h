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
};
/// \param protocols  not empty
Json toJson(const std::vector<LogProtocol>& protocols, const LogEvidence& evidence);
/// The one that tells most.
const LogProtocol& bestOf(const std::vector<LogProtocol>& protocols);

Json toJson(const MotionSeparation& result, const MotionEvidence& evidence);
/// "next_1.csv": of a motion's place among those to record.
std::string nextMotionFile(int chosen);

/// Of any of these results.
std::string separationText(const Json& result);

}  // namespace simgap
