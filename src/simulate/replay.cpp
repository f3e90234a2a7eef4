#include "simgap/simulate/replay.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "pose_plausibility.h"
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
  refuseImplausiblePoses(model, set);
  return set;
}

std::unique_ptr<Evaluator> makeEvaluator(const std::string& name, const PoseProtocol& protocol) {
  return name == "bullet" ? makeBulletEvaluator(protocol, 0) : makeEquilibriumEvaluator(0);
}

Assessment replayAll(Evaluator& evaluator, const ArmModel& model, const PoseSet& set,
                     const std::function<void(std::size_t)>& progress, PoseObjective objective) {
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
  return assess(model.poseLayout(), poses, outcomes, objective);
}

std::vector<StretchedCord> cordsBeyondLinear(std::span<const PoseOutcome> outcomes, std::size_t muscles) {
  std::vector<StretchedCord> cords;
  for (std::size_t m = 0; m < muscles; ++m) {
    double largest = 0.0;
    for (const PoseOutcome& outcome : outcomes) {
      if (!outcome.cord_expansion.empty()) largest = std::max(largest, outcome.cord_expansion[m]);
    }
    if (largest > ShockCord::kLinearRange) cords.push_back({m, largest});
  }
  return cords;
}

std::vector<std::string> stretchedCords(std::span<const PoseOutcome> outcomes, const PoseLayout& layout) {
  std::vector<std::string> sentences;
  for (const StretchedCord& cord : cordsBeyondLinear(outcomes, layout.muscles.size())) {
    sentences.push_back(
        fmt::format("{}: its cord is stretched by {:.0f} % of its rest length, it is linear only up to {:.0f} %",
                    layout.muscles[cord.muscle], 100.0 * cord.expansion, 100.0 * ShockCord::kLinearRange));
  }
  return sentences;
}

std::string otherEquilibria(const ArmModel& model, const PoseSet& set, std::span<const PoseOutcome> outcomes) {
  constexpr std::size_t kMostNamed = 8;
  if (std::ranges::any_of(model.muscles, &Muscle::rope)) return "";  // equilibria know no ropes
  EquilibriumArm arm(model);
  std::vector<std::string> poses;
  for (std::size_t p = 0; p < outcomes.size(); ++p) {
    stopIfInterrupted();
    if (outcomes[p].status != PoseStatus::kSteady) continue;
    arm.setHistory(set.poses[p].time, set.poses[p].shafts_before);
    if (!arm.solveFrom(outcomes[p].joints, outcomes[p].shafts).stable) continue;
    const std::vector<JointPosition> found = arm.joints();
    if (distinctEquilibria(arm, outcomes[p].shafts, found).size() > 1) poses.push_back(set.poses[p].name);
  }
  if (poses.empty()) return "";
  const std::size_t named = std::min(poses.size(), kMostNamed);
  std::string text =
      fmt::format("{}: another stable equilibrium exists for {} of {} poses: {}", set.file, poses.size(),
                  set.poses.size(), fmt::join(poses.begin(), poses.begin() + std::ptrdiff_t(named), " "));
  return named < poses.size() ? text + fmt::format(" and {} more", poses.size() - named) : text;
}

namespace {

/// What a user can change about a pose that ended so.
std::string helpFor(PoseStatus status, const std::string& evaluator) {
  const std::string statics =
      evaluator == "bullet"
          ? "; equilibria need no way there (validate --evaluator equilibrium, calibrate --verify none)"
          : "";
  switch (status) {
    case PoseStatus::kAcquisitionError:
      return "a longer protocol.acquisition_s in --config may help" + statics;
    case PoseStatus::kNotSteady:
      return "a longer --settle-s (protocol.settle_s in --config), or damping of joints and cords in the model, may "
             "help" +
             statics;
    case PoseStatus::kNotFinite:
      return "a smaller protocol.step_s in --config may help" + statics;
    default:
      return "--evaluator bullet simulates the way there; wrong attachments, line lengths or shafts have no "
             "equilibrium";
  }
}

}  // namespace

std::string describeInvalid(const Assessment& assessment, const PoseSet& set, const PoseLayout& layout,
                            const std::string& evaluator) {
  constexpr std::size_t kMostNamed = 5;
  const std::size_t invalid = set.poses.size() - assessment.valid;
  std::string text = fmt::format("{} of {} poses are invalid", invalid, set.poses.size());
  std::size_t named = 0;
  PoseStatus first = PoseStatus::kSteady;
  for (std::size_t p = 0; p < set.poses.size() && named < kMostNamed; ++p) {
    const PoseOutcome& outcome = assessment.outcomes[p];
    if (outcome.status == PoseStatus::kSteady) continue;
    if (named == 0) first = outcome.status;
    text += (named++ == 0 ? ": " : "; ") + set.poses[p].name + ": " + describe(outcome, layout);
  }
  if (named < invalid) text += fmt::format("; and {} more", invalid - named);
  return text + "; " + helpFor(first, evaluator);
}

}  // namespace simgap
