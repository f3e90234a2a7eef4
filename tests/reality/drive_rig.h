/// \file
/// Logs of a Bowden-cable drive on a bench, with a secret in them. The motion is prescribed; friction is a bristle
/// state integrated in time, temperature a state heated by the losses and by the room, the sensors are noisy, quantised
/// and may be biased or late. It shares no code with the models that are judged by it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace simgap::reality {

/// What the drive does besides the load-dependent Stribeck friction that every cable has. 0 (or 1 for powers): nothing.
struct DriveSecret {
  double coulomb_offset = 0.0;   ///< [N m] dry friction without load
  double static_offset = 0.0;    ///< [N m] of breakaway only
  double load_quadratic = 0.0;   ///< [1/(N m)]
  double direction_share = 0.0;  ///< of dry friction, by direction
  double backdrive_share = 0.0;  ///< of all friction, by the sign of the power
  double viscous_bend = 0.0;     ///< viscous friction x (|w| / 100 rad/s)^bend
  double inertia = 0.0;          ///< [N m s^2/rad] of the motor's acceleration
  double hidden_weight = 0.0;    ///< [N m] below the torque sensor
  double hidden_angle = 0.0;     ///< [rad] at which it hangs down
  double capstan = 0.0;          ///< [1/rad]
  double ripple = 0.0;           ///< [N m]
  double ripple_ratio = 0.0;     ///< periods per joint turn
  double bristle_travel = 0.02;  ///< [rad] of the motor: every drive has some
  double ageing = 0.0;           ///< [N m] per e-fold of rest
  double viscous_heating = 0.0;  ///< [1/K]
  double dry_heating = 0.0;      ///< [1/K]
  double magnet_heating = 0.0;   ///< [1/K]
  double saturation = 0.0;       ///< [1/A^2]
  double current_bias = 0.0;     ///< [A]
  double torque_bias = 0.0;      ///< [N m] that the sensor shows too little
  double gauge_bend = 0.0;       ///< [1/(N m)] by which the one gauge of the sensor's bridge unbalances it
  double delay = 0.0;            ///< [s] by which the current is logged late
  double sensor_filter = 0.0;    ///< [s] time constant of the torque sensor's amplifier
  double change_share = 0.0;     ///< of dry friction, from change_time on
  double change_time = 0.0;      ///< [s]
  /// \name Outside every catalogue
  ///@{
  double humid_friction = 0.0;   ///< share of friction per 10 % of humidity
  double humid_current = 0.0;    ///< [A] per 10 % of humidity
  double humid_threshold = 0.0;  ///< share of friction above 45 % humidity
  double humid_angle = 0.0;      ///< share of friction per 10 % of humidity and rad
  double vibration = 0.0;        ///< share of friction that a logged vibration takes away
  ///@}
};

struct DriveRig {
  double torque_per_ampere = 1.2;  ///< [N m/A]
  double sliding = 0.28;           ///< share of the load
  double breakaway = 0.38;         ///< share of the load
  double viscous = 0.015;          ///< [N m s/rad]
  double stribeck_speed = 6.0;     ///< [rad/s]
  double stribeck_power = 1.2;
  double ratio = 97.74;                               ///< motor per joint
  double current_noise = 0.25, current_memory = 0.6;  ///< [A] and correlation of neighbours
  double velocity_noise = 0.15, torque_noise = 0.03, angle_noise = 5e-4;
  std::size_t rows = 30000;
  double rate = 50.0;          ///< [Hz]
  double largest_load = 15.0;  ///< [N m]
  std::uint64_t seed = 1;
};

struct DriveRecord {
  std::vector<double> time, current, velocity, torque, angle, temperature, humidity, vibration;
  std::vector<int> session;
  std::string csv() const;
};

DriveRecord recordDrive(const DriveRig& rig, const DriveSecret& secret);
/// A log whose joint hangs on a cable that is soft at first and stiffens (003 fig. 15): the record with a motor angle
/// of its own, from an encoder read 3 ms after the joint's. \param ratio  motor per joint; \param stretch  [rad] of the
/// joint under large loads.
/// \param play  [rad] between motor and joint, across which the joint falls in a few rows when its load turns
std::string csvWithMotorAngle(const DriveRecord& record, double ratio, double stretch, double play = 0.0);

/// The share of the mean squared current that the secret adds to the noise and that a law with load-dependent Stribeck
/// friction cannot take up, as a fraction of what it leaves: about the gain a model of the secret would have.
double expectedGain(const DriveRig& rig, const DriveSecret& secret);

}  // namespace simgap::reality
