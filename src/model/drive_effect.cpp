#include "simgap/model/drive_effect.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>

#include "simgap/core/error.h"

namespace simgap {

std::string_view toString(Channel channel) {
  switch (channel) {
    case Channel::kJointAngle:
      return "joint_position_rad";
    case Channel::kMotorAngle:
      return "motor_position_rad";
    case Channel::kTemperature:
      return "temperature_degC";
  }
  return "";
}

bool appliesTo(const DriveEffect& effect, DriveKind kind) {
  if (effect.kind == kind) return true;
  if (kind != DriveKind::kGearbox || effect.kind != DriveKind::kFriction) return false;
  // The gearbox's own causes say these in its words; and where rows at jumps are left out, no delay can be seen.
  constexpr std::array kOthers = {"load-dependence", "backdrive-asymmetry",   "stribeck",
                                  "position-ripple", "presliding-hysteresis", "channel-delay"};
  return std::ranges::find(kOthers, effect.name) == kOthers.end();
}

const DriveEffect& drive_effects::find(std::string_view name) {
  std::string known;
  for (const DriveEffect* effect : all()) {
    if (effect->name == name) return *effect;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", effect->name);
  }
  throw ConfigError(fmt::format("found no effect '{}' on actuators, expected one of {}", name, known));
}

}  // namespace simgap
