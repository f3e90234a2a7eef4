#include "simgap/fit/actuators/actuator_model.h"

#include <fmt/format.h>

#include <algorithm>
#include <limits>

#include "simgap/core/error.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap {
namespace {

ActuatorBase baseOf(std::string_view name) {
  const auto kind = std::ranges::find(log_kinds::all(), name, &LogKind::name);
  if (kind == log_kinds::all().end() || (*kind)->prepare == nullptr) return friction::find(name);
  if (const ActuatorEquation* const equation = actuator_equations::find((*kind)->kind)) return *equation;
  return {friction::find((*kind)->law != nullptr ? (*kind)->law : name), (*kind)->kind};
}

}  // namespace

ActuatorModel subjectOf(std::string_view name) {
  ActuatorModel subject{baseOf(name), {}, {}};
  if (const char* const effect = kindOf(subject.base.kind).effect) {
    subject.effects.push_back(&actuator_effects::find(effect));
  }
  return subject;
}

ActuatorModel subjectOf(const FittedModel& model) {
  ActuatorModel subject = subjectOf(model.kind == "friction" ? model.law : model.kind);
  const double k = model.valueOr("k", std::numeric_limits<double>::infinity());
  if (model.kind == "pam" && std::isfinite(k)) {
    subject.effects.push_back(&actuator_effects::find("tendon-compliance"));
    subject.values.push_back({"tendon-compliance.compliance", "1_N", 1.0 / k});
  }
  if (model.kind == "spring" && model.law == kCord) {
    subject.effects.push_back(&actuator_effects::find("spring-slack"));
    subject.values.push_back({"spring-slack.rest_length", "m", model.value("rest_length")});
  }
  for (const Extension& extension : model.extensions) {
    const ActuatorEffect& effect = actuator_effects::find(extension.effect, extension.form);
    const bool of_angles = kindOf(effect.kind).prepare == nullptr  // made of both angles
        ;
    if (of_angles) {
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
  const auto presliding = std::ranges::find(subject.values, kNuisance, &Estimate::name);
  std::optional<double> largest;
  if (presliding != subject.values.end()) largest = presliding->value;
  const ActuatorRegression regression(subject.base, subject.effects, data, largest);
  return regression.predict(regression.thetaOf(subject.values));
}

}  // namespace simgap
