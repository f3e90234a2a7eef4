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

ActuatorRows ActuatorRows::at(std::span<const Eigen::Index> some) const {
  ActuatorRows rows = *this;
  for (const auto channel :
       {&ActuatorRows::time, &ActuatorRows::elapsed, &ActuatorRows::effort, &ActuatorRows::speed,
        &ActuatorRows::direction, &ActuatorRows::load, &ActuatorRows::acceleration, &ActuatorRows::rest,
        &ActuatorRows::joint_angle, &ActuatorRows::motor_angle, &ActuatorRows::temperature, &ActuatorRows::current,
        &ActuatorRows::current_rate, &ActuatorRows::pressure, &ActuatorRows::contraction, &ActuatorRows::deflection}) {
    if ((rows.*channel).size() > 0) rows.*channel = (this->*channel)(some);
  }
  for (std::size_t k = 0; k < context.size(); ++k) rows.context[k] = context[k](some);
  rows.travel.resize(std::ssize(some));
  rows.session.resize(some.size());
  Eigen::Index i = 0;
  for (std::size_t k = 0; k < some.size(); ++k) {
    double way = 0.0;
    for (; i <= some[k]; ++i) {
      if (i > 0 && direction[i] != direction[i - 1]) way = 0.0;
      way += travel[i];
    }
    rows.travel[static_cast<Eigen::Index>(k)] = way;
    rows.session[k] = session[static_cast<std::size_t>(some[k])];
  }
  return rows;
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
