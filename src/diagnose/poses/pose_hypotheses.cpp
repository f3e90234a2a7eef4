#include "pose_hypotheses.h"

#include <algorithm>
#include <cmath>
#include <set>

namespace simgap {

std::vector<ArmHypothesis> poseHypotheses(const ArmModel& model, std::span<const Pose> poses,
                                          const std::vector<std::string>& effects,
                                          std::vector<NotTestable>& not_testable) {
  const bool timed = std::ranges::none_of(poses, [](const Pose& pose) { return std::isnan(pose.time); });
  std::vector<ArmHypothesis> hypotheses;
  for (const ArmEffect* effect : arm_effects::all()) {
    if (!effects.empty() && std::ranges::find(effects, effect->name) == effects.end()) continue;
    if (effect->needs_motion) continue;
    if (effect->needs_time && !timed) {
      not_testable.push_back({std::string(effect->name), "needs time_s"});
      continue;
    }
    for (const std::string& target : effectTargets(*effect, model)) {
      if (hasExtension(model, *effect, target)) continue;
      ArmHypothesis hypothesis{effect, target, possibleStarts(*effect, target, model)};
      std::erase_if(hypothesis.starts, [&](const EffectParameters& start) {
        return effect->from_previous >= 0 && start[effect->from_previous] != 0.0 && !timed;
      });
      if (!hypothesis.starts.empty()) hypotheses.push_back(std::move(hypothesis));
    }
  }
  return hypotheses;
}

double shareOf(const ArmHypothesis& hypothesis, std::span<const ArmHypothesis> all, std::size_t poses) {
  std::set<const ArmEffect*> effects;
  double targets = 0.0;
  bool whole = false;
  for (const ArmHypothesis& h : all) {
    effects.insert(h.effect);
    if (h.effect != hypothesis.effect) continue;
    whole |= h.target.empty();
    targets += h.target.empty() ? 0.0 : 1.0;
  }
  double ways = hypothesis.target.empty() ? 1.0 : targets;
  if (whole && targets > 0.0) ways *= 2.0;
  // Neighbouring moments are no new hypotheses.
  if (hypothesis.effect->from_moment) ways *= std::max(1.0, 0.25 * static_cast<double>(poses));
  return 1.0 / (static_cast<double>(effects.size()) * ways);
}

}  // namespace simgap
