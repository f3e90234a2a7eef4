/// \file
/// A drawn forearm with one cause hidden, and what a diagnosis makes of its motions.
#pragma once

#include <string>

#include "simgap/core/yaml.h"
#include "simgap/diagnose/motions/motion_diagnosis.h"
#include "support/files.h"
#include "support/motion_draws.h"
#include "support/statics.h"

namespace simgap::test {

struct MotionCase {
  HiddenMotionCase hidden;
  ArmModel model;  ///< what is believed
  MotionDiagnosis said;
};

/// What the forearm of a case does with these draws of commands.
inline MotionSet recordForearm(const HiddenMotionCase& hidden, const ArmModel& model, std::uint64_t first,
                               std::size_t count) {
  const auto commands = [](std::uint64_t draw) { return drawSetpoints(MotionArm::kForearm, draw); };
  return recordMotions(hidden.drawn.truth, model, commands, first, count, hidden.drawn.rig);
}

inline MotionCalibrationConfig motionConfig() {
  return MotionCalibrationConfig::read(YamlNode::load(sourceFile("configs/calibrate_motions.yaml")));
}

inline MotionCase diagnoseForearmWith(const MotionTruth& cause, std::uint64_t seed) {
  MotionCase one{drawHidden(MotionArm::kForearm, seed, cause), {}, {}};
  one.model = modelOf(one.hidden.believed.arm, true);
  const MotionSet selecting = recordForearm(one.hidden, one.model, firstSelecting(seed), kSelectingMotions),
                  judging = recordForearm(one.hidden, one.model, firstJudging(seed), kJudgingMotions);
  one.said = diagnoseMotions(one.model, selecting, &judging, motionConfig(), {}, [](const std::string&, double) {});
  return one;
}

}  // namespace simgap::test
