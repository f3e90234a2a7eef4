#include "arm_cause.h"

#include <algorithm>

namespace simgap {

Eigen::Index fittedParameters(const ArmEffect& effect) {
  return std::ranges::count_if(effect.parameters, [](const ArmEffectParameter& p) { return p.fitted; });
}

ArmModel withCauses(const ArmModel& model, const std::vector<ArmCause>& causes) {
  ArmModel extended = model;
  const ArmSizes arm = sizesOf(model);
  for (const ArmCause& cause : causes) {
    EffectParameters p{};
    for (std::size_t i = 0; i < cause.effect->parameters.size(); ++i) {
      const ArmEffectParameter parameter = onArm(cause.effect->parameters[i], arm);
      p[i] = parameter.fitted ? parameter.neutral : cause.start[i];
    }
    extended.extensions.push_back(makeExtension(*cause.effect, cause.target, p));
  }
  return extended;
}

std::vector<ParameterSpace::Choice> choicesWith(const std::vector<ParameterSpace::Choice>& parameters,
                                                const std::vector<ArmCause>& causes, const ArmSizes& arm) {
  std::vector<ParameterSpace::Choice> choices = parameters;
  for (const ArmCause& cause : causes) {
    for (const ArmEffectParameter& stated : cause.effect->parameters) {
      if (!stated.fitted) continue;
      const ArmEffectParameter p = onArm(stated, arm);
      choices.push_back(
          {"extensions." + cause.label() + "." + std::string(p.name), 0.1 * p.scale, {}, {}, p.scale, {}});
    }
  }
  return choices;
}

std::string labelOf(const std::vector<ArmCause>& causes) {
  std::string label;
  for (const ArmCause& cause : causes) label += (label.empty() ? "" : ", ") + cause.label();
  return label.empty() ? "none" : label;
}

std::vector<ArmCause> causesBeyond(const ArmModel& given, const ArmModel& candidate) {
  std::vector<ArmCause> causes;
  for (std::size_t i = given.extensions.size(); i < candidate.extensions.size(); ++i) {
    const Extension& extension = candidate.extensions[i];
    ArmCause& cause = causes.emplace_back(ArmCause{findArmEffect(extension.effect), extension.target, {}});
    for (std::size_t k = 0; k < extension.parameters.size(); ++k) cause.start[k] = extension.parameters[k].value;
  }
  return causes;
}

}  // namespace simgap
