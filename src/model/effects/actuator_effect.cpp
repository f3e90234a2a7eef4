#include "simgap/model/effects/actuator_effect.h"

#include <fmt/format.h>

#include <algorithm>

#include "simgap/core/error.h"

namespace simgap {

bool appliesTo(const ActuatorEffect& effect, ActuatorKind kind) {
  if (effect.kind == kind || (kind == ActuatorKind::kFriction && effect.on_drive)) return true;
  return kind == ActuatorKind::kGearbox && effect.kind == ActuatorKind::kFriction && effect.on_gearbox;
}

const ActuatorEffect& actuator_effects::find(std::string_view name) {
  std::string known;
  for (const ActuatorEffect* effect : all()) {
    if (effect->name == name) return *effect;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", effect->name);
  }
  throw ConfigError(fmt::format("found no effect '{}' on actuators, expected one of {}", name, known));
}

const ActuatorEffect& actuator_effects::inEveryDrive() {
  return **std::ranges::find_if(all(), [](const ActuatorEffect* effect) { return effect->in_every_drive; });
}

}  // namespace simgap
