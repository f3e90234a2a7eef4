/// \file
/// Logs of drawn robots with one thing hidden, and what a diagnosis makes of them.
#pragma once

#include <algorithm>
#include <string>

#include "reality/robot_flaws.h"
#include "simgap/diagnose/robots/robot_diagnosis.h"
#include "simgap/fit/dynamics/robot_fit.h"
#include "support/robot_logs.h"

namespace simgap::test {

struct RobotCase {
  reality::Robot robot;
  ArmModel arm;
  RobotModel known;  ///< as fit-dynamics has found it from a log without the flaw
};

inline reality::RobotRigOptions shortRig(double seconds) {
  reality::RobotRigOptions rig;
  rig.duration = seconds;
  return rig;
}

inline RobotCase drawCase(std::uint64_t seed, int joints, const reality::RobotRigOptions& rig) {
  RobotCase drawn;
  drawn.robot = reality::randomRobot(seed, joints, seed % 2 == 0, seed % 3 == 0);
  drawn.arm = drawnArm(drawn.robot, seed);
  drawn.known = fitRobot(drawn.arm, robotLog(drawn.arm, reality::recordRobot(drawn.robot, rig, 3 * seed)), {}).model;
  return drawn;
}

inline RobotDiagnosis diagnoseCase(const RobotCase& drawn, const reality::Robot& truth,
                                   const reality::RobotRigOptions& rig, std::uint64_t motion) {
  return diagnoseRobot(drawn.known, robotLog(drawn.known, reality::recordRobot(truth, rig, motion)), {}, {});
}

inline std::string labelOf(const Cause& cause) {
  return cause.target.empty() ? cause.effect : cause.effect + ":" + cause.target;
}

/// "right", "grouped" (among at most three), "missed" (no name) or "wrong".
inline std::string answerFor(const Diagnosis& d, const std::string& label) {
  if (d.verdict == DiagnosisVerdict::kUnexplained || d.causes.empty()) return "missed";
  bool alone = true, found = false;
  for (const Cause& cause : d.causes) {
    const bool own = labelOf(cause) == label;
    const bool grouped = std::ranges::find(cause.ambiguous_with, label) != cause.ambiguous_with.end();
    if (!own && !grouped) return "wrong";
    alone = alone && own && cause.ambiguous_with.empty();
    found = true;
  }
  return !found ? "missed" : alone ? "right" : "grouped";
}

}  // namespace simgap::test
