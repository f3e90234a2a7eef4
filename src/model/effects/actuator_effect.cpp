#include "simgap/model/effects/actuator_effect.h"

#include <fmt/format.h>

#include <algorithm>

#include "simgap/core/error.h"

namespace simgap {

bool appliesTo(const ActuatorEffect& effect, ActuatorKind kind) {
  if (effect.kind == kind || (kind == ActuatorKind::kFriction && effect.on_drive)) return true;
  return kind == ActuatorKind::kGearbox && effect.kind == ActuatorKind::kFriction && effect.on_gearbox;
}

Eigen::ArrayXd Saturation::effort(const Eigen::ArrayXd& i, const Eigen::ArrayXd& i_v) const {
  return i + sag * i.abs() * (i - i_v) + cubic * i.cube() + excess * i.sign() * (i.abs() - knee).max(0.0);
}

Eigen::ArrayXd Saturation::slope(const Eigen::ArrayXd& i, const Eigen::ArrayXd& i_v) const {
  return 1.0 + sag * (2.0 * i.abs() - i.sign() * i_v) + 3.0 * cubic * i.square() +
         excess * (i.abs() > knee).cast<double>();
}

std::string titleOf(const ActuatorEffect& effect) {
  return effect.form.empty() ? std::string(effect.name) : fmt::format("{} ({})", effect.name, effect.form);
}

namespace {

const ActuatorEffect& formOf(const ActuatorEffect& effect, std::string_view form) {
  if (form.empty() || effect.form == form) return effect;
  std::string known(effect.form);
  for (const ActuatorEffect* other : effect.other_forms) {
    if (other->form == form) return *other;
    known += fmt::format(", {}", other->form);
  }
  throw ConfigError(fmt::format("found the form '{}' of {}, expected {}", form, effect.name,
                                known.empty() ? "none: it has one" : "one of " + known));
}

}  // namespace

const ActuatorEffect& actuator_effects::find(std::string_view name, std::string_view form) {
  std::string known;
  for (const ActuatorEffect* effect : all()) {
    if (effect->name == name) return formOf(*effect, form);
    known += fmt::format("{}{}", known.empty() ? "" : ", ", effect->name);
  }
  throw ConfigError(fmt::format("found no effect '{}' on actuators, expected one of {}", name, known));
}

const ActuatorEffect& actuator_effects::ofTransmission() {
  return **std::ranges::find(all(), ActuatorKind::kTransmission, &ActuatorEffect::kind);
}

const ActuatorEffect& actuator_effects::inEveryDrive() {
  return **std::ranges::find_if(all(), [](const ActuatorEffect* effect) { return effect->in_every_drive; });
}

}  // namespace simgap
