#include "simgap/model/drive_effect.h"

#include <fmt/format.h>

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
  return effect.name != "load-dependence" && effect.name != "backdrive-asymmetry" && effect.name != "position-ripple" &&
         effect.name != "presliding-hysteresis";
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
