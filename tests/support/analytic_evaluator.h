/// \file
/// A calibration without physics: the joints stand where a formula of the parameters puts them.
#pragma once

#include <functional>
#include <vector>

#include "simgap/fit/poses/calibration.h"

namespace simgap::test {

/// A shoulder (spherical), an elbow (revolute) and two muscles, "biceps" and "triceps".
ArmModel analyticArm();

/// Two poses that analyticArm() reaches exactly when the lines of biceps and triceps are 0.3 m and 0.1 m long (they
/// begin at 0.1 m and 0.2 m).
std::vector<Pose> analyticPoses();

/// Searches the two lines, (3, 12)-ES over 8 generations.
CalibrationConfig analyticConfig();

/// elbow = line of biceps + pose number; shoulder = turned about x by the line of triceps.
class AnalyticEvaluator : public Evaluator {
 public:
  /// May change an outcome, to make it invalid: (model, pose number, outcome).
  using Spoiler = std::function<void(const ArmModel&, std::size_t, PoseOutcome&)>;
  explicit AnalyticEvaluator(Spoiler spoil = {}) : spoil_(std::move(spoil)) {}

  std::vector<PoseOutcome> evaluate(std::span<const ArmModel> models, std::span<const Pose> poses,
                                    AfterInvalid after_invalid) override;

 private:
  Spoiler spoil_;
};

}  // namespace simgap::test
