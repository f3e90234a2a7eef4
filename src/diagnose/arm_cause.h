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
  std::string label() const {
    return target.empty() ? std::string(effect->name) : std::string(effect->name) + ":" + target;
  }
};

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

/// With an interval that holds no value which the parameter cannot have.
inline Estimate withIntervalIn(const ArmEffectParameter& parameter, const Estimate& estimate, double half) {
  Estimate e = withInterval(estimate, half);
  e.lower95 = std::clamp(e.lower95, std::min(parameter.range.lower, e.value), e.value);
  e.upper95 = std::clamp(e.upper95, e.value, std::max(parameter.range.upper, e.value));
  return e;
}

}  // namespace simgap
