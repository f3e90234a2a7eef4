#include "motion_hypotheses.h"

#include <algorithm>

namespace simgap {
namespace {

/// Why motions do not show an effect; empty when they do.
std::string_view hiddenFromMotions(const ArmEffect& effect) {
  if (effect.needs_time || effect.from_moment) return "needs poses: it acts over a session, not within seconds";
  if (effect.stiction) return "is the joint's Coulomb friction while it moves, a parameter of every fit";
  if (effect.from_previous >= 0) return "is guide-friction while the arm moves";
  return {};
}

}  // namespace

bool ofOneMuscle(const ArmHypothesis& hypothesis) {
  using enum ArmEffect::Target;
  return !hypothesis.target.empty() &&
         (hypothesis.effect->target == kMuscle || hypothesis.effect->target == kMuscleOrAll);
}

bool looksLike(const ArmHypothesis& hypothesis, const ArmCause& cause) {
  const auto names = [](const ArmEffect& effect, const ArmEffect& other) {
    return std::ranges::find(effect.look_alikes, other.name) != effect.look_alikes.end();
  };
  if (ofOneMuscle(hypothesis) && hypothesis.target != cause.target) return false;
  return names(*cause.effect, *hypothesis.effect) || names(*hypothesis.effect, *cause.effect);
}

std::vector<ArmHypothesis> motionHypotheses(const ArmModel& model, const std::vector<std::string>& effects,
                                            std::vector<NotTestable>& not_testable) {
  std::vector<ArmHypothesis> hypotheses;
  for (const ArmEffect* effect : arm_effects::all()) {
    if (!effects.empty() && std::ranges::find(effects, effect->name) == effects.end()) continue;
    if (const std::string_view why = hiddenFromMotions(*effect); !why.empty()) {
      not_testable.push_back({std::string(effect->name), std::string(why)});
      continue;
    }
    for (const std::string& target : effectTargets(*effect, model)) {
      if (hasExtension(model, *effect, target)) continue;
      ArmHypothesis hypothesis{effect, target, possibleStarts(*effect, target, model)};
      if (!hypothesis.starts.empty()) hypotheses.push_back(std::move(hypothesis));
    }
  }
  return hypotheses;
}

}  // namespace simgap
