#include "simgap/diagnose/logs/refitted_model.h"

#include <fmt/format.h>

#include <algorithm>

#include "simgap/core/units.h"

namespace simgap {
namespace {

/// Of a winding, a muscle or a spring: what was fitted replaces what the file had; the tendon's spring of 002 and a
/// cord's rest length are parameters there.
void takeOver(const LogFit& fit, FittedModel& model) {
  const auto put = [&](const Estimate& parameter) {
    std::erase_if(model.parameters, [&](const Estimate& p) { return p.name == parameter.name; });
    model.parameters.push_back(parameter);
  };
  for (const Estimate& p : fit.parameters) {
    if (p.name.find('.') == std::string::npos) put({p.name, p.unit, p.value, p.sd, false});
  }
  if (model.kind == "spring") {
    model.law.clear();
    std::erase_if(model.parameters, [](const Estimate& p) { return p.name == "rest_length"; });
    const auto slack = std::ranges::find(model.extensions, "spring-slack", &Extension::effect);
    if (slack == model.extensions.end()) return;
    model.law = kCord;
    put(slack->parameters[0]);
    model.extensions.erase(slack);
  }
  if (model.kind != "pam") return;
  model.law = "no-spring";
  std::erase_if(model.parameters, [](const Estimate& p) { return p.name == "k"; });
  const auto spring = std::ranges::find(model.extensions, "tendon-compliance", &Extension::effect);
  if (spring == model.extensions.end()) return;
  const Estimate& compliance = spring->parameters[0];
  model.law = "spring";
  put({"k", "N", 1.0 / compliance.value, compliance.sd / (compliance.value * compliance.value), false});
  model.extensions.erase(spring);
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
    takeOver(fit, model);
    return model;
  }
  model.kind = "friction";
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
