#include "simgap/diagnose/logs/refitted_model.h"

#include <fmt/format.h>

#include <algorithm>

#include "simgap/core/units.h"
#include "simgap/measure/logs/log_kind.h"

namespace simgap {
namespace {

/// A parameter that models of this kind hold as their own, for the effect that stands for it.
void replaceByOwn(const ActuatorEffect& effect, FittedModel& model) {
  const OwnParameter& own = *effect.own_parameter;
  model.law = own.law_without;
  std::erase_if(model.parameters, [&](const Estimate& p) { return p.name == own.name; });
  const auto found = std::ranges::find(model.extensions, effect.name, &Extension::effect);
  if (found == model.extensions.end()) return;
  Estimate p = found->parameters.front();
  if (own.inverse) p.sd /= p.value * p.value;
  p.value = own.convert(p.value);
  p.name = own.name;
  if (!own.unit.empty()) p.unit = own.unit;
  model.law = own.law;
  model.parameters.push_back(p);
  model.extensions.erase(found);
}

/// Of a winding, a muscle or a spring: what was fitted replaces what the file had.
void takeOver(const LogFit& fit, ActuatorKind kind, FittedModel& model) {
  for (const Estimate& fitted : fit.parameters) {
    if (fitted.name.find('.') != std::string::npos) continue;
    std::erase_if(model.parameters, [&](const Estimate& p) { return p.name == fitted.name; });
    model.parameters.push_back({fitted.name, fitted.unit, fitted.value, fitted.sd, false});
  }
  for (const ActuatorEffect* effect : actuator_effects::all()) {
    if (effect->own_parameter != nullptr && effect->kind == kind) replaceByOwn(*effect, model);
  }
}

}  // namespace

FittedModel refittedModel(const FittedModel& given, const ActuatorModel& subject, const LogFit& fit,
                          const PreparedLog& log, const LogSource& source) {
  FittedModel model = given;
  model.covariance.resize(0, 0);
  model.data_file = source.file;
  model.data_sha256 = source.sha256;
  model.data_rows = source.rows;
  model.extensions = fit.extensions;
  if (subject.base.equation != nullptr) {
    model.kind = subject.base.name();
    takeOver(fit, subject.base.kind, model);
    return model;
  }
  model.kind = kindOf(ActuatorKind::kFriction).name;
  model.law = subject.base.name();
  model.parameters.clear();
  for (const Estimate& p : fit.parameters) {
    const bool own = p.name.find('.') == std::string::npos;
    if (own) model.parameters.push_back({p.name, p.unit, p.value, p.sd, false});
  }
  model.settings["effort"] = log.data.effort_unit;
  model.settings.try_emplace("predicts", "effort");
  model.settings[quantityName("dead_band", log.data.velocity_unit)] = fmt::format("{}", log.dead_band);
  return model;
}

}  // namespace simgap
