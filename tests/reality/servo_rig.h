/// \file
/// Logs of position-controlled drives as they are logged, with a secret in them. A sampled controller moves the drive
/// from place to place and holds it there; friction is a band of forces at rest (time stepping after Moreau 1988) or a
/// bristle (LuGre: Canudas de Wit et al. 1995), with a Lorentzian Stribeck curve, and a held drive creeps. Only an
/// encoder is logged, with spikes, jittering stamps, a gap and here and there a clipped channel. Causes have other
/// shapes than any closed form of the catalogue. It shares no code with the models that are judged by it.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace simgap::reality {

/// What is driven. Torques are those of the shaft whose angle is logged, except for the cable, where they are the
/// joint's (as a torque sensor there reads them) while the motor's angle is logged.
enum class Mechanism {
  kCable,        ///< a Bowden cable lifts hanging loads, a sensor measures them; friction in proportion to the load
  kGearedJoint,  ///< a robot's joint with a vertical axis: inertia and friction, no load
  kPendulum,     ///< a motor with a known weight on a lever
  kVoltageServo  ///< the same as a hobby servo: its effort is the voltage, speed costs back-EMF
};

/// What a drive does besides its ordinary friction. 0: nothing. Torques in N m, speeds of the logged shaft.
struct ServoSecret {
  double dry_offset = 0.0;          ///< of dry friction
  double static_offset = 0.0;       ///< of breakaway only
  double load_power = 0.0;          ///< cable: x |load|^1.6
  double load_share = 0.0;          ///< dry friction per load
  double direction_share = 0.0;     ///< of dry friction, by direction
  double backdrive_share = 0.0;     ///< of dry friction, by the sign of the power
  double viscous_asymmetry = 0.0;   ///< of viscous friction, by direction
  double viscous_saturation = 0.0;  ///< viscous friction / (1 + this x |w| / top speed)
  double stribeck_share = 0.0;      ///< more breakaway, as a share of dry friction
  double inertia = 0.0;             ///< [N m s^2/rad]
  double hidden_weight = 0.0;       ///< [N m]
  double hidden_angle = 0.0;        ///< [rad]
  double harness = 0.0;             ///< [N m/rad] stiffness of cables that hang at the joint
  double harness_angle = 0.0;       ///< [rad] at which they are relaxed, or become taut
  bool harness_slack = false;       ///< they pull on one side only, from a soft beginning on; else more beyond 1 rad
  double bend = 0.0;                ///< [1/rad] dry friction x (1 + bend angle), or with a saturating bend
  bool bend_saturates = false;      ///< the bend acts as tanh(1.5 angle) / 1.5
  bool bend_both_ways = false;      ///< the bend acts as |angle|, rounded
  double ripple = 0.0;              ///< [N m], with half of it at the second and a quarter at the third harmonic
  double ripple_ratio = 0.0;        ///< periods per turn of the joint
  double bristle_travel = 0.0;      ///< [rad] until friction has built up; 0: as the rig has it
  double ageing = 0.0;              ///< [N m] x (rest / 1 s)^0.35 of breakaway
  double friction_heating = 0.0;    ///< [1/K] all friction / (1 + this (T - 28))
  double magnet_heating = 0.0;      ///< [1/K] current x (1 + this (T - 28))
  double knee_loss = 0.0;           ///< effort above a knee costs (1 + this) times as much
  double knee = 0.0;                ///< effort at which it begins
  double rail_sag = 0.0;            ///< [1/V] voltage servo: share of the rail that each volt over the winding takes
  double bias = 0.0;                ///< of the logged effort
  double delay = 0.0;               ///< [s] by which the effort is logged late
  double change_share = 0.0;        ///< of dry friction, growing in within 3 s
  double change_time = 0.0;         ///< [s]
  double headroom = 0.0;            ///< share of the largest effort that the supply cannot give at top speed
  double backlash = 0.0;            ///< [rad] of dead travel, then contact
  /// \name Outside every catalogue
  ///@{
  double humid_friction = 0.0;  ///< share of friction per 10 % of humidity
  double supply_effort = 0.0;   ///< share of effort per volt of the supply
  double neighbour = 0.0;       ///< share of the neighbour's torque that reaches this joint
  ///@}
};

struct ServoRig {
  Mechanism mechanism = Mechanism::kCable;
  bool bristle = false;       ///< LuGre instead of a band
  double strength = 1.2;      ///< [N m/A], of the voltage servo [N m/V]
  double dry = 0.0;           ///< [N m] sliding friction
  double dry_per_load = 0.0;  ///< of the cable
  double breakaway = 1.4;     ///< times sliding friction
  double stribeck_speed = 4.0;
  double viscous = 0.015;  ///< [N m s/rad]
  double back_emf = 0.0;   ///< [V s/rad]
  double inertia = 5e-4;   ///< [N m s^2/rad]
  double weight = 0.0;     ///< [N m] of the pendulum; the largest of the cable's
  double ratio = 1.0;      ///< logged shaft per joint
  double top_speed = 1.0;  ///< [rad/s] of the logged shaft
  double largest_effort = 12.0;
  /// \name Sensors
  ///@{
  double counts = 2000.0;  ///< of the encoder, per turn
  double effort_noise = 0.25, effort_memory = 0.5, effort_step = 0.02;
  double load_noise = 0.03;    ///< [N m] of the cable's torque sensor
  double spike_share = 4e-4;   ///< of rows whose encoder is wrong once
  double jitter = 0.06;        ///< of a step
  bool stamps_lie = false;     ///< samples are equidistant, only their stamps jitter
  double gap = 12.0;           ///< [s] that are lost once
  double clipped_share = 0.0;  ///< of rows whose effort is beyond the converter
  ///@}
  double off_every = 0.0;  ///< [s] after which the motor is switched off for 1.5 s: it logs 0 and falls; 0: never
  double rate = 50.0;      ///< [Hz]
  std::size_t rows = 16000;
  std::uint64_t seed = 1;
};

struct ServoRecord {
  Mechanism mechanism = Mechanism::kCable;
  std::vector<double> time, effort, position, load, joint, temperature, humidity, supply, neighbour, speed;
  std::vector<double> extra;  ///< what the secret adds to the effort; never logged
  std::vector<bool> moving;   ///< never logged
  std::vector<int> session;
  double clip = 0.0;  ///< effort beyond which the converter clips
  double step = 0.0;  ///< of the converter
  /// As the bench logs it. \param without  true: the same log as if nothing were hidden.
  std::string csv(bool without = false) const;
};

/// How the dry friction falls with speed.
inline double lorentzian(double w, double scale) { return 1.0 / (1.0 + (w / scale) * (w / scale)); }

inline constexpr double kServoGravity = 9.81, kServoLever = 0.15;

/// What happened, as perfect sensors would log it.
ServoRecord driveServo(const ServoRig& rig, const ServoSecret& secret);
/// What the rig logs of it.
ServoRecord recordServo(const ServoRig& rig, const ServoSecret& secret);

/// Of the mean squared error that a law with the rig's kinds of friction leaves, the share that is the secret's: about
/// the gain a model of the secret would have. Rests do not count.
double expectedGain(const ServoRig& rig, const ServoSecret& secret);

/// How `simgap diagnose` is asked: options of the mechanism, and the bench it needs (empty: the torque sensor).
std::vector<std::string> diagnoseOptions(const ServoRig& rig);
std::string benchYaml(const ServoRig& rig);

}  // namespace simgap::reality
