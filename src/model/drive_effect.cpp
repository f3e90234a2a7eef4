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

const DriveEffect& drive_effects::find(std::string_view name) {
  std::string known;
  for (const DriveEffect* effect : all()) {
    if (effect->name == name) return *effect;
    known += fmt::format("{}{}", known.empty() ? "" : ", ", effect->name);
  }
  throw ConfigError(fmt::format("found no effect '{}' on drives, expected one of {}", name, known));
}

}  // namespace simgap
