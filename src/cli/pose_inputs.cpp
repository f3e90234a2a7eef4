#include "pose_inputs.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/progress.h"
#include "simgap/model/arm/arm_effect.h"
#include "simgap/report/html/assets.h"
#include "simgap/simulate/equilibrium_arm.h"

namespace simgap {

ArmModel parseArm(const Input& input) { return readArm(YamlNode::parse(input.content, input.file.string())); }

CalibrationConfig parseConfig(const Input& input) {
  return CalibrationConfig::read(YamlNode::parse(input.content, input.file.string()));
}

Input readConfig(Session& session, const std::string& file) {
  if (!file.empty()) return session.read("config", file);
  return {"config", "configs/calibrate_arm.yaml", std::string(assets::calibrate_arm_yaml())};
}

std::unique_ptr<Evaluator> makeEvaluator(const std::string& name, const PoseProtocol& protocol, int threads) {
  return name == "bullet" ? makeBulletEvaluator(protocol, threads) : makeEquilibriumEvaluator(threads);
}

PoseSet parsePoses(const Input& input, const ArmModel& model, const CsvOptions& options) {
  const CsvTable table = CsvTable::parse(input.content, input.file.string(), options);
  if (table.skippedRows() > 0) spdlog::warn("{}: {} bad rows left out", table.name(), table.skippedRows());
  PoseSet set = readPoseSet(table, model.poseLayout());
  for (const ArmExtension& extension : resolveExtensions(model)) {
    if (extension.effect->needs_time && std::isnan(set.poses.front().time)) {
      throw DataError(fmt::format("{}: found no column time_s, expected it: the model's {} needs it", set.file,
                                  extension.effect->name));
    }
  }
  return set;
}

Assessment replayAll(Evaluator& evaluator, const ArmModel& model, const PoseSet& set, const std::string& label,
                     bool quiet) {
  constexpr std::size_t kPosesAtOnce = 64;  // between two looks at the clock
  Progress progress(label + ": pose", set.poses.size(), quiet);
  std::vector<PoseOutcome> outcomes;
  const std::span<const Pose> poses(set.poses);
  while (outcomes.size() < poses.size()) {
    const auto some = poses.subspan(outcomes.size(), std::min(kPosesAtOnce, poses.size() - outcomes.size()));
    for (PoseOutcome& outcome : evaluator.evaluate({&model, 1}, some, AfterInvalid::kGoOn)) {
      outcomes.push_back(std::move(outcome));
    }
    if (interruptRequested()) throw InterruptedError("interrupted; nothing to resume, run the command again");
    progress.update(outcomes.size());
  }
  return assess(model.poseLayout(), poses, outcomes);
}

void warnAboutCords(std::span<const PoseOutcome> outcomes, const PoseLayout& layout) {
  for (std::size_t m = 0; m < layout.muscles.size(); ++m) {
    double largest = 0.0;
    for (const PoseOutcome& outcome : outcomes) {
      if (!outcome.cord_expansion.empty()) largest = std::max(largest, outcome.cord_expansion[m]);
    }
    if (largest > ShockCord::kLinearRange) {
      spdlog::warn("{}: its cord is stretched by {:.0f} % of its rest length, it is linear only up to {:.0f} %",
                   layout.muscles[m], 100.0 * largest, 100.0 * ShockCord::kLinearRange);
    }
  }
}

void warnAboutOtherEquilibria(const ArmModel& model, const PoseSet& set, std::span<const PoseOutcome> outcomes) {
  EquilibriumArm arm(model);
  std::string poses;
  for (std::size_t p = 0; p < outcomes.size(); ++p) {
    if (outcomes[p].status != PoseStatus::kSteady) continue;
    if (!arm.solveFrom(outcomes[p].joints, outcomes[p].shafts).stable) continue;
    const std::vector<JointPosition> found = arm.joints();
    if (distinctEquilibria(arm, outcomes[p].shafts, found).size() > 1) poses += " " + set.poses[p].name;
  }
  if (!poses.empty()) spdlog::warn("{}: another stable equilibrium exists for pose{}", set.file, poses);
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
