/// \file
/// The rows of an actuator's log as models and effects see them: one array per channel, whatever the log was of.
#pragma once

#include <Eigen/Core>
#include <span>
#include <string_view>
#include <vector>

namespace simgap {

/// A channel as the functions of `core` take it.
inline std::span<const double> spanOf(const Eigen::ArrayXd& values) {
  return {values.data(), static_cast<std::size_t>(values.size())};
}

/// What a log is of.
enum class ActuatorKind {
  kFriction,      ///< a drive: effort against load and motion
  kGearbox,       ///< the same of a motor with a gearbox on a bench
  kMotor,         ///< a winding: voltage against current and speed
  kPam,           ///< a pneumatic muscle: force against pressure and contraction
  kSpring,        ///< a spring, cord or tendon: force against one deflection
  kTransmission,  ///< between the two angles of a drive: the joint's against the motor's
};

/// What not every log has.
enum class OptionalChannel {
  kJointAngle,
  kMotorAngle,
  kTemperature,
  kLoad,        ///< that changes
  kLoadSensor,  ///< a load that was measured, not worked out from a bench's weights
  kRest,        ///< of 1 s and longer
  kTime,        ///< without it a log is rows in their order
  kTurn,        ///< a joint that turns: a slide's position is no angle
};
std::string_view toString(OptionalChannel channel);

/// The rows of a log as effects see them; every array has shape (n), or is empty when the log has no such channel.
struct ActuatorRows {
  Eigen::ArrayXd time;                  ///< [s] of the session's clock
  Eigen::ArrayXd elapsed;               ///< [s] as elapsedOf
  Eigen::ArrayXd effort;                ///< what the motor drew; a winding's voltage, a muscle's or spring's force
  Eigen::ArrayXd speed;                 ///< [rad/s]
  Eigen::ArrayXd direction;             ///< +1 or -1: the last direction of motion, held through rests
  Eigen::ArrayXd travel;                ///< [rad] in that direction since the row before, >= 0
  Eigen::ArrayXd load;                  ///< [N m]
  Eigen::ArrayXd acceleration;          ///< [rad/s^2]
  Eigen::ArrayXd rest;                  ///< [s] how long the current rest lasts, or the last one lasted
  Eigen::ArrayXd joint_angle;           ///< [rad]
  Eigen::ArrayXd motor_angle;           ///< [rad]
  Eigen::ArrayXd temperature;           ///< [deg C]
  Eigen::ArrayXd current;               ///< [A] of a winding
  Eigen::ArrayXd current_rate;          ///< [A/s]
  double current_noise = 0.0;           ///< [A] standard deviation of the current's noise
  Eigen::ArrayXd pressure;              ///< [Pa] gauge, of a muscle
  Eigen::ArrayXd contraction;           ///< [1] apparent: of the muscle with its tendon
  Eigen::ArrayXd deflection;            ///< [m] or [rad] of a spring
  std::vector<Eigen::ArrayXd> context;  ///< further logged channels, scaled to mean 0 and standard deviation 1
  std::vector<int> session;             ///< shape (n)
  double step = 0.0;                    ///< [s] median time between rows
  double top_speed = 0.0;               ///< [rad/s]
  double top_load = 0.0;                ///< [N m]
  bool timed = true;                    ///< false: `time` counts rows
  bool load_measured = false;           ///< false: worked out, or none
  bool turns = true;                    ///< false: joint_angle is the position of a slide [m]

  Eigen::Index rows() const { return time.size(); }
  bool has(OptionalChannel channel) const;
  /// Some of them. \param some  in their order; travel is since the one before, or since the last reversal
  ActuatorRows at(std::span<const Eigen::Index> some) const;
};

/// Time since the log began: a session whose clock begins anew follows the one before it at once; else `time`.
/// \param time  [s], shape (n)  \param session  shape (n)
Eigen::ArrayXd elapsedOf(const Eigen::ArrayXd& time, const std::vector<int>& session);

}  // namespace simgap
