#include "simgap/fit/actuators/actuator_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "simgap/core/error.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap {
namespace {

/// What explains the logs of a kind: its equation, its law, or else the model's.
ActuatorModel subjectOf(const LogKind& kind, std::string_view law) {
  const ActuatorEquation* const equation = actuator_equations::find(kind.kind);
  ActuatorModel subject{equation != nullptr
                            ? ActuatorBase(*equation)
                            : ActuatorBase(friction::find(kind.law != nullptr ? kind.law : law), kind.kind),
                        {},
                        {}};
  if (kind.effect != nullptr) subject.effects.push_back(&actuator_effects::find(kind.effect));
  return subject;
}

/// Effects that models of this kind hold as parameters of their own.
void addOwnParameters(const FittedModel& model, const LogKind& kind, ActuatorModel& subject) {
  for (const ActuatorEffect* effect : actuator_effects::all()) {
    const OwnParameter* const own = effect->own_parameter;
    if (own == nullptr || effect->kind != kind.kind || (model.law != own->law && !model.has(own->name))) continue;
    const double value = model.value(own->name);
    if (!std::isfinite(value)) continue;
    const EffectParameter& parameter = effect->parameters.front();
    subject.effects.push_back(effect);
    subject.values.push_back(
        {fmt::format("{}.{}", effect->name, parameter.name), std::string(parameter.unit), own->convert(value)});
  }
}

}  // namespace

std::optional<double> ActuatorModel::presliding() const {
  const auto nuisance = std::ranges::find(values, kNuisance, &Estimate::name);
  return nuisance == values.end() ? std::nullopt : std::optional(nuisance->value);
}

ActuatorModel subjectOf(std::string_view name) {
  const LogKind* const kind = log_kinds::find(name);
  if (kind == nullptr || kind->prepare == nullptr) return {friction::find(name), {}, {}};
  return subjectOf(*kind, name);
}

ActuatorModel subjectOf(const FittedModel& model) {
  const LogKind* const kind = log_kinds::find(model.kind);
  ActuatorModel subject = subjectOf(*kind, model.law);
  addOwnParameters(model, *kind, subject);
  for (const Extension& extension : model.extensions) {
    const ActuatorEffect& effect = actuator_effects::find(extension.effect, extension.form);
    if (&effect == &actuator_effects::ofTransmission()) {
      subject.of_angles.push_back(extension);
    } else {
      subject.effects.push_back(&effect);
    }
    for (const Estimate& p : extension.parameters) {
      const bool known =
          std::ranges::find(effect.columns, p.name, &EffectColumn::name) != effect.columns.end() ||
          std::ranges::find(effect.parameters, p.name, &EffectParameter::name) != effect.parameters.end();
      if (!known) {
        throw ConfigError(fmt::format("found the parameter {} in the extension {}, which has none of that name", p.name,
                                      effect.name));
      }
      subject.values.push_back({fmt::format("{}.{}", effect.name, p.name), p.unit, p.value, p.sd});
    }
    for (const EffectColumn& column : effect.columns) static_cast<void>(extension.value(column.name));
    for (const EffectParameter& p : effect.parameters) static_cast<void>(extension.value(p.name));
  }
  subject.values.insert(subject.values.end(), model.parameters.begin(), model.parameters.end());
  return subject;
}

Eigen::ArrayXd predictExtended(const ActuatorModel& subject, const ActuatorData& data) {
  const ActuatorRegression regression(subject.base, subject.effects, data, subject.presliding());
  return regression.predict(regression.thetaOf(subject.values));
}

}  // namespace simgap
