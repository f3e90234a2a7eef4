#include "arm_cause.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"

namespace simgap {

Eigen::Index fittedParameters(const ArmEffect& effect) {
  return std::ranges::count_if(effect.parameters, [](const ArmEffectParameter& p) { return p.fitted; });
}

void requireArmEffects(const std::vector<std::string>& names) {
  for (const std::string& name : names) {
    if (findArmEffect(name)) continue;
    std::vector<std::string_view> known;
    for (const ArmEffect* effect : arm_effects::all()) known.push_back(effect->name);
    throw ConfigError(fmt::format("--effects: found '{}', expected some of {}", name, fmt::join(known, ", ")));
  }
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

bool hasExtension(const ArmModel& model, const ArmEffect& effect, const std::string& target) {
  return std::ranges::any_of(
      model.extensions, [&](const Extension& given) { return given.effect == effect.name && given.target == target; });
}

std::vector<ArmCause> withOneMore(std::vector<ArmCause> causes, const ArmCause& more) {
  causes.push_back(more);
  return causes;
}

std::vector<ArmCause> withoutOne(std::vector<ArmCause> causes, std::size_t cause) {
  causes.erase(causes.begin() + static_cast<std::ptrdiff_t>(cause));
  return causes;
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

std::string doubtOfSize(const ArmEffect& effect, const std::vector<Estimate>& estimates) {
  const ArmEffectParameter& first = effect.parameters[0];
  for (std::size_t k = 0; k < effect.parameters.size(); ++k) {
    const ArmEffectParameter& p = effect.parameters[k];
    const bool is_size = p.fitted && p.unit == first.unit && p.neutral == first.neutral;
    const double half = std::isfinite(estimates[k].sd) ? 1.96 * estimates[k].sd : 0.0;
    if (is_size && std::abs(estimates[k].value - p.neutral) > half) return {};
  }
  return fmt::format("there may be none of it: {} = {:.3g} ± {:.2g}", first.name, estimates[0].value,
                     1.96 * estimates[0].sd);
}

}  // namespace simgap
