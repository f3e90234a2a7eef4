#include "simgap/fit/poses/replay.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/model/arm/arm_effect.h"
#include "simgap/simulate/equilibrium_arm.h"

namespace simgap {

PoseSet readPosesFor(const ArmModel& model, const CsvTable& table) {
  PoseSet set = readPoseSet(table, model.poseLayout());
  for (const ArmExtension& extension : resolveExtensions(model)) {
    if (extension.effect->needs_time && std::isnan(set.poses.front().time)) {
      throw DataError(fmt::format("{}: found no column time_s, expected it: the model's {} needs it", set.file,
                                  extension.effect->name));
    }
  }
  return set;
}

std::unique_ptr<Evaluator> makeEvaluator(const std::string& name, const PoseProtocol& protocol) {
  return name == "bullet" ? makeBulletEvaluator(protocol, 0) : makeEquilibriumEvaluator(0);
}

Assessment replayAll(Evaluator& evaluator, const ArmModel& model, const PoseSet& set,
                     const std::function<void(std::size_t)>& progress) {
  constexpr std::size_t kPosesAtOnce = 64;  // between two looks at the clock
  std::vector<PoseOutcome> outcomes;
  const std::span<const Pose> poses(set.poses);
  while (outcomes.size() < poses.size()) {
    const auto some = poses.subspan(outcomes.size(), std::min(kPosesAtOnce, poses.size() - outcomes.size()));
    for (PoseOutcome& outcome : evaluator.evaluate({&model, 1}, some, AfterInvalid::kGoOn)) {
      outcomes.push_back(std::move(outcome));
    }
    stopIfInterrupted();
    if (progress) progress(outcomes.size());
  }
  return assess(model.poseLayout(), poses, outcomes);
}

std::vector<std::string> stretchedCords(std::span<const PoseOutcome> outcomes, const PoseLayout& layout) {
  std::vector<std::string> sentences;
  for (std::size_t m = 0; m < layout.muscles.size(); ++m) {
    double largest = 0.0;
    for (const PoseOutcome& outcome : outcomes) {
      if (!outcome.cord_expansion.empty()) largest = std::max(largest, outcome.cord_expansion[m]);
    }
    if (largest <= ShockCord::kLinearRange) continue;
    sentences.push_back(
        fmt::format("{}: its cord is stretched by {:.0f} % of its rest length, it is linear only up to {:.0f} %",
                    layout.muscles[m], 100.0 * largest, 100.0 * ShockCord::kLinearRange));
  }
  return sentences;
}

std::string otherEquilibria(const ArmModel& model, const PoseSet& set, std::span<const PoseOutcome> outcomes) {
  EquilibriumArm arm(model);
  std::string poses;
  for (std::size_t p = 0; p < outcomes.size(); ++p) {
    if (outcomes[p].status != PoseStatus::kSteady) continue;
    if (!arm.solveFrom(outcomes[p].joints, outcomes[p].shafts).stable) continue;
    const std::vector<JointPosition> found = arm.joints();
    if (distinctEquilibria(arm, outcomes[p].shafts, found).size() > 1) poses += " " + set.poses[p].name;
  }
  return poses.empty() ? "" : fmt::format("{}: another stable equilibrium exists for pose{}", set.file, poses);
}

std::string describeInvalid(const Assessment& assessment, const PoseSet& set, const PoseLayout& layout) {
  std::string text = fmt::format("{} of {} poses are invalid", set.poses.size() - assessment.valid, set.poses.size());
  std::string separator = ": ";
  for (std::size_t p = 0; p < set.poses.size(); ++p) {
    if (assessment.outcomes[p].status == PoseStatus::kSteady) continue;
    text += separator + set.poses[p].name + ": " + describe(assessment.outcomes[p], layout);
    separator = "; ";
  }
  return text;
}

}  // namespace simgap
