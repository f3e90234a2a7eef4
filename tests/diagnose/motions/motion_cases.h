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
  MotionDiagnosis said;
  double magnitude;    ///< of what is hidden
  std::string target;  ///< as the model names it
};

inline MotionCase diagnoseForearmWith(const MotionTruth& cause, std::uint64_t seed) {
  const HiddenMotionCase hidden = drawHidden(MotionArm::kForearm, seed, cause);
  const ArmModel model = modelOf(hidden.believed.arm, true);
  const auto record = [&](std::uint64_t first, std::size_t count) {
    const auto commands = [](std::uint64_t draw) { return drawSetpoints(MotionArm::kForearm, draw); };
    return recordMotions(hidden.drawn.truth, model, commands, first, count, hidden.drawn.rig);
  };
  const MotionSet selecting = record(firstSelecting(seed), kSelectingMotions),
                  judging = record(firstJudging(seed), kJudgingMotions);
  const MotionCalibrationConfig config =
      MotionCalibrationConfig::read(YamlNode::load(sourceFile("configs/calibrate_motions.yaml")));
  return {diagnoseMotions(model, selecting, &judging, config, {}, [](const std::string&, double) {}), hidden.magnitude,
          hidden.target};
}

}  // namespace simgap::test
