#include <fmt/format.h>

#include <algorithm>

#include "simgap/report/diagnosis/diagnosis_report.h"
#include "simgap/simulate/arm_geometry.h"
#include "simgap/simulate/equilibrium_arm.h"

namespace simgap {
namespace {

constexpr std::size_t kMostFrames = 60, kMostLines = 1500;

/// The held-out motion of which the causes take most; without causes the one that is missed most.
std::size_t tellingMotion(const MotionDiagnosis& result) {
  std::size_t best = result.held_out.motions.size();
  double most = -kInfinity;
  for (std::size_t m = 0; m < result.held_out.motions.size(); ++m) {
    if (!result.before[m].valid || !result.after[m].valid) continue;
    const auto say = std::ranges::find(result.motions, result.held_out.motions[m].name, &MotionSay::motion);
    const double taken = result.diagnosis.causes.empty() ? say->before : say->before - say->after;
    if (taken > most) best = m;
    most = std::max(most, taken);
  }
  return best;
}

std::size_t rowAt(const std::vector<double>& times, double time) {
  const auto after = std::ranges::upper_bound(times, time);
  return after == times.begin() ? 0 : static_cast<std::size_t>(after - times.begin()) - 1;
}

/// Where a model has the arm at a frame, with the expansions of its cords.
PoseOutcome outcomeAt(PotentialEnergy& energy, const RecordedMotion& motion, const PlayedMotion& played,
                      std::size_t frame) {
  const ArmModel& model = energy.model();
  PoseOutcome outcome;
  outcome.status = PoseStatus::kSteady;
  const auto joints = std::span(played.joints).subspan(frame * model.joints.size(), model.joints.size());
  outcome.joints.assign(joints.begin(), joints.end());
  const std::size_t row = rowAt(motion.times(), motion.joint_times[frame]);
  const auto column = static_cast<Eigen::Index>(row);
  outcome.shafts.resize(model.commands());  // behind the shafts what lines are told
  for (std::size_t c = 0; c < outcome.shafts.size(); ++c) {
    const auto i = static_cast<Eigen::Index>(c);
    outcome.shafts[c] = c < model.muscles.size() ? played.shafts(i, column) : motion.commands.values(i, column);
  }
  energy.setShafts(outcome.shafts);
  energy.evaluate(outcome.joints);
  for (std::size_t m = 0; m < model.muscles.size(); ++m) {
    outcome.cord_expansion.push_back(energy.expansion(m) / model.muscles[m].shock_cord.rest_length);
  }
  return outcome;
}

}  // namespace

void writeMotionScene(const MotionDiagnosis& result, const RunDirectory& directory) {
  const std::size_t m = tellingMotion(result);
  if (m == result.held_out.motions.size()) return;
  const RecordedMotion& motion = result.held_out.motions[m];
  const ArmModel before_model = withoutRopes(result.baseline), after_model = withoutRopes(result.model);
  const std::size_t lines = std::max<std::size_t>(before_model.muscles.size(), 1), all = motion.joint_times.size();
  const std::size_t frames = std::min({kMostFrames, std::max<std::size_t>(kMostLines / lines, 2), all});
  PotentialEnergy before_energy(before_model), after_energy(after_model);
  PoseSet measured;
  std::vector<PoseOutcome> before, after;
  for (std::size_t i = 0; i < frames; ++i) {
    const std::size_t frame = frames < 2 ? 0 : i * (all - 1) / (frames - 1);
    Pose pose;
    pose.name = fmt::format("{:.2f} s", motion.joint_times[frame]);
    pose.joints = motion.joints[frame];
    measured.poses.push_back(std::move(pose));
    before.push_back(outcomeAt(before_energy, motion, result.before[m], frame));
    after.push_back(outcomeAt(after_energy, motion, result.after[m], frame));
  }
  std::vector<ReplayedSet> replays{{motion.name, "without causes", before_model, measured, before}};
  if (!result.diagnosis.causes.empty()) {
    replays.push_back({motion.name, "with the causes", after_model, measured, after});
  }
  writeArmGeometry(replays, directory);
}

}  // namespace simgap
