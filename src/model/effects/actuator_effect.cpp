#include "simgap/model/effects/actuator_effect.h"

#include <fmt/format.h>

#include <algorithm>

#include "simgap/core/error.h"

namespace simgap {

bool appliesTo(const ActuatorEffect& effect, ActuatorKind kind) {
  if (effect.kind == kind || (kind == ActuatorKind::kFriction && effect.on_drive)) return true;
  return kind == ActuatorKind::kGearbox && effect.kind == ActuatorKind::kFriction && effect.on_gearbox;
}

namespace {

constexpr double kLeast = 0.2;  // of a supply's voltage is left: less than a half is beyond its largest power

/// What is left of a supply's voltage.
Eigen::ArrayXd leftBySag(double sag, const Eigen::ArrayXd& i, const Eigen::ArrayXd& i_v) {
  return (1.0 - sag * i.sign() * (i - i_v)).max(kLeast);
}

}  // namespace

Eigen::ArrayXd Saturation::effort(const Eigen::ArrayXd& i, const Eigen::ArrayXd& i_v) const {
  return i / leftBySag(sag, i, i_v) + cubic * i.cube() + excess * i.sign() * (i.abs() - knee).max(0.0);
}

// d/dI of I / (1 - s sign(I) (I - I_v)) = (1 + s sign(I) I_v) / (1 - s sign(I) (I - I_v))^2
Eigen::ArrayXd Saturation::slope(const Eigen::ArrayXd& i, const Eigen::ArrayXd& i_v) const {
  const Eigen::ArrayXd left = leftBySag(sag, i, i_v);
  return (left > kLeast).select((1.0 + sag * i.sign() * i_v) / left.square(), 1.0 / left) + 3.0 * cubic * i.square() +
         excess * (i.abs() > knee).cast<double>();
}

Eigen::ArrayXd Saturation::slopeBySpeed(const Eigen::ArrayXd& i, const Eigen::ArrayXd& i_v) const {
  const Eigen::ArrayXd left = leftBySag(sag, i, i_v);
  return (left > kLeast).select(-sag * i.abs() / left.square(), 0.0);
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
