#include "simgap/model/effects/actuator_effect.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "simgap/core/error.h"

namespace simgap {

bool appliesTo(const ActuatorEffect& effect, ActuatorKind kind) {
  if (effect.kind == kind) return true;
  if (kind != ActuatorKind::kGearbox || effect.kind != ActuatorKind::kFriction) return false;
  // The gearbox's own causes say these in its words; and where rows at jumps are left out, no delay can be seen.
  constexpr std::array kOthers = {"load-dependence", "backdrive-asymmetry",   "stribeck",
                                  "position-ripple", "presliding-hysteresis", "channel-delay"};
  return std::ranges::find(kOthers, effect.name) == kOthers.end();
}

const ActuatorEffect& actuator_effects::find(std::string_view name) {
  std::string known;
  for (const ActuatorEffect* effect : all()) {
    if (effect->name == name) return *effect;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", effect->name);
  }
  throw ConfigError(fmt::format("found no effect '{}' on actuators, expected one of {}", name, known));
}

}  // namespace simgap
