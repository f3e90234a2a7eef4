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
    case OptionalChannel::kTurn:
      return "a joint that turns";
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
    case OptionalChannel::kTurn:
      return turns;
  }
  return false;
}

Eigen::ArrayXd elapsedOf(const Eigen::ArrayXd& time, const std::vector<int>& session) {
  Eigen::ArrayXd elapsed = time;
  double before = 0.0;  // what the clocks of earlier sessions showed
  for (Eigen::Index i = 1; i < time.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (session[k] != session[k - 1] && time[i] <= time[i - 1]) before += time[i - 1] - time[i];
    elapsed[i] += before;
  }
  return elapsed;
}

}  // namespace simgap
