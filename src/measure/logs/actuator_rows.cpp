#include "simgap/measure/logs/actuator_rows.h"

namespace simgap {

std::string_view toString(OptionalChannel channel) {
  switch (channel) {
    case OptionalChannel::kJointAngle:
      return "joint_position_rad";
    case OptionalChannel::kMotorAngle:
      return "motor_position_rad";
    case OptionalChannel::kTemperature:
      return "temperature_degC";
  }
  return "";
}

bool ActuatorRows::has(OptionalChannel channel) const {
  switch (channel) {
    case OptionalChannel::kJointAngle:
      return joint_angle.size() > 0;
    case OptionalChannel::kMotorAngle:
      return motor_angle.size() > 0;
    case OptionalChannel::kTemperature:
      return temperature.size() > 0;
  }
  return false;
}

}  // namespace simgap
