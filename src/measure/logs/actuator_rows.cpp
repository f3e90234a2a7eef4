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
    case OptionalChannel::kLoad:
      return "a load that changes";
    case OptionalChannel::kLoadSensor:
      return "a load that a sensor measures";
    case OptionalChannel::kRest:
      return "rests of 1 s and longer";
    case OptionalChannel::kTime:
      return "time_s";
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
    case OptionalChannel::kLoad:
      return top_load != 0.0;
    case OptionalChannel::kLoadSensor:
      return load_measured;
    case OptionalChannel::kRest:
      return (rest > 0.5).any();
    case OptionalChannel::kTime:
      return timed;
  }
  return false;
}

}  // namespace simgap
