/// \file
/// A joint of two pneumatic muscles and a motor over time (002 section III): its equations of motion, its controller,
/// and the commands both are given.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/measure/motion_commands.h"
#include "simgap/model/actuator/exo_joint.h"
#include "simgap/simulate/leg_switch.h"

namespace simgap {

/// The joint's state, and what acts on it. Integrated by the classical Runge-Kutta method of fourth order.
class ExoJointMotion {
 public:
  /// What a state is made of, in its order.
  enum : Eigen::Index {
    kAngle,             ///< theta [rad]
    kVelocity,          ///< [rad/s]
    kFlexorPressure,    ///< [Pa]
    kExtensorPressure,  ///< [Pa]
    kFlexorBristle,     ///< bent bristles of the braid, -1 … 1
    kExtensorBristle,
    kDryBristle,  ///< of the joint's dry friction
    kStateSize
  };
  using State = Eigen::Matrix<double, kStateSize, 1>;

  struct Inputs {
    double flexor_pressure = 0.0, extensor_pressure = 0.0;  ///< references of the valves [Pa]
    double current = 0.0;                                   ///< of the motor [A]
    double external = 0.0;                                  ///< torque from outside [N m]
  };

  explicit ExoJointMotion(const ExoJoint& joint);
  /// At rest at an angle, under pressures that have settled.
  void reset(double angle, const Inputs& inputs);
  void step(const Inputs& inputs, double duration);

  const State& state() const { return state_; }
  double angle() const { return state_[kAngle]; }
  double velocity() const { return state_[kVelocity]; }
  double flexorForce() const { return flexorForce(state_); }      ///< with the braid's friction [N]
  double extensorForce() const { return extensorForce(state_); }  ///< [N]
  double muscleTorque() const { return muscleTorque(state_); }    ///< 002 eq. 10 [N m]
  double motorTorque(double current) const;                       ///< [N m]

 private:
  State derivative(const State& state, const Inputs& inputs) const;
  double flexorForce(const State& state) const;
  double extensorForce(const State& state) const;
  double muscleTorque(const State& state) const;
  double stopTorque(const State& state) const;

  ExoJoint joint_;
  double inertia_ = 0.0, coulomb_ = 0.0, viscous_ = 0.0;  ///< with the motor's behind its gear
  State state_ = State::Zero();
};

/// What the joint is told over time: a torque, or pressures and a current; and a torque from outside.
struct ExoJointCommands {
  bool torque = true;        ///< rows of `over_time`: torque, external; else flexor, extensor, current, external
  MotionCommands over_time;  ///< [N m], [Pa], [A]
  bool switched = false;     ///< the torque is one of the joint's two, as a switch says
};

/// Columns `torque_Nm`, or `pressure_flexor_Pa`, `pressure_extensor_Pa` and, where there is a motor, `current_A` (0);
/// `external_torque_Nm` (0). \throws DataError: neither, both a torque and a current, a pressure or a current beyond
/// what the joint's supply and motor give, and as readCommands
ExoJointCommands readExoJointCommands(const ExoJoint& joint, const CsvTable& table, bool linear);
/// The torques of the joint's two states, with its lag between them, at every tick from the first state on.
/// \param end  [s] \throws ConfigError: a joint without a switch
ExoJointCommands switchedTorques(const ExoJoint& joint, const LegSwitch& told, double end);
/// The same names under `joint:` of a `simgap/schedule/1`.  \throws ConfigError
ExoJointCommands readExoJointSchedule(const ExoJoint& joint, const YamlNode& root);

/// How a joint is played.
struct ExoJointPlay {
  bool tendons = true;  ///< the controller knows of the tendons' springs
  bool motor = true;    ///< the motor takes the rest
  double step = 1e-4;   ///< largest step of the integration [s]
  double settle = 3.0;  ///< under the first commands before time begins [s]
};

/// The joint at every tick of its controller; vectors of shape (ticks).
struct ExoJointTrack {
  std::vector<double> time, angle, velocity;                                             ///< [s], [rad], [rad/s]
  std::vector<double> flexor_pressure, extensor_pressure, flexor_force, extensor_force;  ///< [Pa], [N]
  std::vector<double> desired;                  ///< empty: pressures are commanded
  std::vector<double> muscles, motor, missing;  ///< [N m]
  std::vector<double> stiffness;                ///< of the muscles [N m/rad]
};

/// \param end  on the commands' clock [s]  \throws NumericsError: it blew up
ExoJointTrack playExoJoint(const ExoJoint& joint, const ExoJointCommands& commands, double end,
                           const ExoJointPlay& play);

}  // namespace simgap
