/// \file
/// A physical cause put into the model of an arm, and its parameters among those of a fit.
#pragma once

#include <algorithm>
#include <string>
#include <vector>

#include "simgap/model/arm/arm_effect.h"
#include "simgap/model/arm/parameter_space.h"

namespace simgap {

/// A cause with its choices made, and where the fit of it begins.
struct ArmCause {
  const ArmEffect* effect = nullptr;
  std::string target;
  EffectParameters start{};
  std::string label() const { return effectLabel(effect->name, target); }
};

/// An effect on a target that a model does not have yet, with all starts that fits of it try.
struct ArmHypothesis {
  const ArmEffect* effect = nullptr;
  std::string target;
  std::vector<EffectParameters> starts;  ///< the first where motions show it most easily
  std::string label() const { return effectLabel(effect->name, target); }
  bool isOf(const ArmCause& cause) const { return cause.effect == effect && cause.target == target; }
};

/// \throws ConfigError: one of the names, of --effects, is that of no effect
void requireArmEffects(const std::vector<std::string>& names);

/// Where fits of an effect begin, with those of its choices that the target has: a muscle that crosses one joint cannot
/// bend round a second.
std::vector<EffectParameters> possibleStarts(const ArmEffect& effect, const std::string& target, const ArmModel& model);
/// Whether a model has an effect on a target.
bool hasExtension(const ArmModel& model, const ArmEffect& effect, const std::string& target);

/// The causes and one more.
std::vector<ArmCause> withOneMore(std::vector<ArmCause> causes, const ArmCause& more);
/// The causes without one of them. \param cause  its place
std::vector<ArmCause> withoutOne(std::vector<ArmCause> causes, std::size_t cause);

/// What a search changes of a cause: without a choice or a moment.
Eigen::Index fittedParameters(const ArmEffect& effect);

/// The model with causes at their expected values, choices as they were made.
ArmModel withCauses(const ArmModel& model, const std::vector<ArmCause>& causes);
/// The parameters of a fit with theirs, each with the prior that the effect states for an arm of those sizes.
std::vector<ParameterSpace::Choice> choicesWith(const std::vector<ParameterSpace::Choice>& parameters,
                                                const std::vector<ArmCause>& causes, const ArmSizes& arm);

/// "payload:forearm, guide-friction"; "none"
std::string labelOf(const std::vector<ArmCause>& causes);
/// The causes that a candidate has beyond the given model, with the values and choices that it has.
std::vector<ArmCause> causesBeyond(const ArmModel& given, const ArmModel& candidate);

/// Why data do not tell that there is any of a cause; empty where one of its sizes, which are alike in unit and neutral
/// value, is further from none than chance leaves it. \param estimates  of its parameters, in their order
std::string doubtOfSize(const ArmEffect& effect, const std::vector<Estimate>& estimates);

/// With an interval that holds no value which the parameter cannot have.
inline Estimate withIntervalIn(const ArmEffectParameter& parameter, const Estimate& estimate, double half) {
  Estimate e = withInterval(estimate, half);
  e.lower95 = std::clamp(e.lower95, std::min(parameter.range.lower, e.value), e.value);
  e.upper95 = std::clamp(e.upper95, e.value, std::max(parameter.range.upper, e.value));
  return e;
}

}  // namespace simgap
