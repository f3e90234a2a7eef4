/// \file
/// Feed-forward of a drive with load-dependent friction, for simulators and controllers: one header without
/// dependencies, no allocation, some ten nanoseconds a call.
///
///     I_m    = (tau_ext + tau_fr) / k_a + I_0                                        003 eq. 3
///     tau_fr = (tau_c + (tau_s - tau_c) exp(-|w / v_s|^delta)) sign(w) + k_v w       003 eq. 4
///     tau_c  = n_c1 |tau_ext| + n_c2,   tau_s = n_s1 |tau_ext| + n_s2                003 eq. 7-11
///
/// w is the motor's velocity. The paper's classic model has n_c2 = n_s2 = 0, its variant A n_s2 = 0.
///
///     simgap::DriveFeedForward drive;            // values of model.yaml
///     drive.k_a = 1.31;
///     drive.friction = {.n_c1 = 0.21, .n_c2 = 0.35, .n_s1 = 0.28, .k_v = 0.002, .v_s = 8.4, .delta = 1.1};
///     simgap::DirectionHold hold(0.7);           // `dead_band_rad_s` of model.yaml
///     double current = drive.effort(torque, velocity, hold.update(velocity));    // every millisecond
#pragma once

#include <cmath>

namespace simgap {

struct StribeckFriction {
  double n_c1 = 0.0;   ///< Coulomb friction per load [1]
  double n_c2 = 0.0;   ///< Coulomb friction without load [N m]
  double n_s1 = 0.0;   ///< static friction per load [1]
  double n_s2 = 0.0;   ///< static friction without load [N m]
  double k_v = 0.0;    ///< viscous friction [N m s/rad]
  double v_s = 1.0;    ///< Stribeck velocity [rad/s], > 0
  double delta = 1.0;  ///< Stribeck exponent [1], > 0

  /// What dry friction comes to, whatever its direction. \param velocity [rad/s] \param load [N m] \returns [N m]
  double dry(double velocity, double load) const noexcept {
    const double stick = std::exp(-std::pow(std::abs(velocity / v_s), delta));
    const double coulomb = n_c1 * std::abs(load) + n_c2;
    const double breakaway = n_s1 * std::abs(load) + n_s2;
    return coulomb + (breakaway - coulomb) * stick;
  }
  /// \param velocity [rad/s]  \param direction  +1 or -1: last direction of motion; 0: no friction but viscous.
  /// \param load [N m]  \returns [N m]
  double torque(double velocity, double direction, double load) const noexcept {
    return dry(velocity, load) * direction + k_v * velocity;
  }
};

struct DriveFeedForward {
  StribeckFriction friction;
  double k_a = 1.0;     ///< torque per effort [N m/A]
  double offset = 0.0;  ///< I_0 [A], or [N m] of a model that predicts torque

  /// Motor current (or what the model's effort is) that moves `load` [N m] at `velocity` [rad/s].
  double effort(double load, double velocity, double direction) const noexcept {
    return (load + friction.torque(velocity, direction, load)) / k_a + offset;
  }
  /// Torque [N m] at the load of a model that was fitted to predict it: friction grows with the motor's own torque.
  double load(double effort, double velocity, double direction) const noexcept {
    const double motor = k_a * effort;
    return motor - friction.torque(velocity, direction, motor) + offset;
  }
};

/// The direction friction acts against, sample by sample: the last direction of motion, held through the dead band.
class DirectionHold {
 public:
  /// \param dead_band [rad/s] half width, some noise levels of the velocity.
  explicit DirectionHold(double dead_band) noexcept : dead_band_(dead_band) {}
  double update(double velocity) noexcept {
    if (std::abs(velocity) > dead_band_) direction_ = velocity > 0.0 ? 1.0 : -1.0;
    return direction_;
  }

 private:
  double dead_band_;
  double direction_ = 0.0;
};

}  // namespace simgap
