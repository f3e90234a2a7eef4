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

bool hasAlready(const ArmModel& model, const Extension& extension) {
  return std::ranges::any_of(
      model.extensions, [&](const Extension& given) { return extensionLabel(given) == extensionLabel(extension); });
}

}  // namespace

bool ofOneMuscle(const MotionHypothesis& hypothesis) {
  using enum ArmEffect::Target;
  return !hypothesis.target.empty() &&
         (hypothesis.effect->target == kMuscle || hypothesis.effect->target == kMuscleOrAll);
}

bool looksLike(const MotionHypothesis& hypothesis, const ArmCause& cause) {
  const auto names = [](const ArmEffect& effect, const ArmEffect& other) {
    return std::ranges::find(effect.look_alikes, other.name) != effect.look_alikes.end();
  };
  if (ofOneMuscle(hypothesis) && hypothesis.target != cause.target) return false;
  return names(*cause.effect, *hypothesis.effect) || names(*hypothesis.effect, *cause.effect);
}

std::vector<EffectParameters> possibleStarts(const ArmEffect& effect, const std::string& target,
                                             const ArmModel& model) {
  std::vector<EffectParameters> starts;
  const ArmSizes arm = sizesOf(model);
  for (const EffectParameters& stated : effect.starts) {
    const EffectParameters start = startOn(effect, stated, arm);
    Extension extension = makeExtension(effect, target, start);
    if (checkExtension(extension, model).empty()) starts.push_back(start);
  }
  return starts;
}

std::vector<MotionHypothesis> motionHypotheses(const ArmModel& model, const std::vector<std::string>& effects,
                                               std::vector<NotTestable>& not_testable) {
  std::vector<MotionHypothesis> hypotheses;
  for (const ArmEffect* effect : arm_effects::all()) {
    if (!effects.empty() && std::ranges::find(effects, effect->name) == effects.end()) continue;
    if (const std::string_view why = hiddenFromMotions(*effect); !why.empty()) {
      not_testable.push_back({std::string(effect->name), std::string(why)});
      continue;
    }
    for (const std::string& target : effectTargets(*effect, model)) {
      if (hasAlready(model, makeExtension(*effect, target, effect->starts.front()))) continue;
      MotionHypothesis hypothesis{effect, target, possibleStarts(*effect, target, model)};
      if (!hypothesis.starts.empty()) hypotheses.push_back(std::move(hypothesis));
    }
  }
  return hypotheses;
}

}  // namespace simgap
