/// \file
/// A drive led along a path or to a torque, with its friction compensated (003 section 2.3, fig. 6 and eq. 3), for
/// simulators and controllers: one header besides feed_forward.h, no allocation, some ten nanoseconds a call.
///
///     v   = v_ref + k_p (q_ref - q)                                                position, then velocity
///     tau = k_v (v - w / N) + k_i integral(v - w / N)
///     I   = (tau + tau_des + c tau_fr(tau_des, w)) / k_a + I_0                       003 eq. 3 and a feedback
///
/// w: the motor's velocity; q: its angle over the ratio N, as 003 takes no notice of the cable; tau_des: what the joint
/// is known to carry along the path, or the torque it shall give, which is fed forward alone (tau = 0); c: share of the
/// friction that is compensated.
///
///     simgap::Trapezoid reference(2.5, 20.0);                 // rad/s, rad/s^2 of the joint
///     simgap::VelocityObserver motor(1000.0);
///     simgap::TrajectoryController controller(gains, drive, 0.9);
///     reference.update(set_point, dt), motor.update(encoder, dt);                       // every tick
///     double current = controller.follow(reference.position(), reference.velocity(), weight(reference.position()),
///                                        motor.angle(), motor.velocity(), dt);
#pragma once

#include <algorithm>
#include <cmath>

#include "simgap/model/actuator/feed_forward.h"

namespace simgap {

/// Goes to a set-point, which may change at any time, with a trapezoid of velocity that ends there at rest.
class Trapezoid {
 public:
  /// \param velocity [rad/s] \param acceleration [rad/s^2]: the largest, both > 0
  Trapezoid(double velocity, double acceleration) noexcept : most_(velocity), acceleration_(acceleration) {}

  void reset(double position) noexcept { position_ = position, velocity_ = 0.0; }

  void update(double goal, double dt) noexcept {
    const double change = acceleration_ * dt, way = goal - position_;
    if (std::abs(way) <= 0.5 * change * dt && std::abs(velocity_) <= change) return reset(goal);
    // v with v^2 / (2 a) + (v + v_before) dt / 2 = way: from there it just stops at the goal.
    const double side = way >= 0.0 ? 1.0 : -1.0, before = side * velocity_;
    const double left = std::abs(way) - 0.5 * before * dt;
    const double stopping =
        left > 0.0 ? std::sqrt(0.25 * change * change + 2.0 * acceleration_ * left) - 0.5 * change : 0.0;
    const double now = std::clamp(std::min(stopping, most_), before - change, before + change);
    position_ += 0.5 * side * (before + now) * dt;
    velocity_ = side * now;
  }
  double position() const noexcept { return position_; }  ///< [rad]
  double velocity() const noexcept { return velocity_; }  ///< [rad/s]

 private:
  double most_, acceleration_;
  double position_ = 0.0, velocity_ = 0.0;
};

/// Angle and velocity from an encoder's counts: a phase-locked loop with both poles at -`bandwidth`.
class VelocityObserver {
 public:
  /// \param bandwidth [rad/s], well below 1 / dt
  explicit VelocityObserver(double bandwidth) noexcept : bandwidth_(bandwidth) {}
  void reset(double angle) noexcept { angle_ = angle, velocity_ = 0.0; }
  void update(double measured, double dt) noexcept {
    angle_ += velocity_ * dt;
    const double error = measured - angle_;
    angle_ += 2.0 * bandwidth_ * error * dt;
    velocity_ += bandwidth_ * bandwidth_ * error * dt;
  }
  double angle() const noexcept { return angle_; }        ///< [rad]
  double velocity() const noexcept { return velocity_; }  ///< [rad/s]

 private:
  double bandwidth_;
  double angle_ = 0.0, velocity_ = 0.0;
};

struct TrajectorySettings {
  double ratio = 1.0;            ///< N: motor per joint
  double position_gain = 0.0;    ///< k_p [1/s]
  double velocity_gain = 0.0;    ///< k_v [N m s/rad] of the joint
  double integrator_gain = 0.0;  ///< k_i [N m/rad] of the joint
  double current_limit = 0.0;    ///< [A]
  double dead_band = 0.0;        ///< [rad/s] of the motor, in which the sign of friction is held
  bool by_reference = false;     ///< friction is that of the reference's velocity, not of the measured one
};

class TrajectoryController {
 public:
  /// \param drive  what is believed of it \param share  c, of its friction that is compensated
  TrajectoryController(const TrajectorySettings& settings, const DriveFeedForward& drive, double share) noexcept
      : settings_(settings), drive_(drive), share_(share), direction_(settings.dead_band) {}

  /// \param position, velocity  reference of the joint [rad], [rad/s] \param load  it is known to carry there [N m]
  /// \param angle, motor  measured at the motor [rad], [rad/s] \returns the current [A], within its limit
  double follow(double position, double velocity, double load, double angle, double motor, double dt) noexcept {
    const double wanted = velocity + settings_.position_gain * (position - angle / settings_.ratio);
    const double error = wanted - motor / settings_.ratio;
    const double more = settings_.integrator_gain * error * dt;
    const double feedback = settings_.velocity_gain * error + integral_ + more;
    const double current = limited(feedback, load, settings_.by_reference ? settings_.ratio * velocity : motor);
    // At the limit the integral stands still, or it would grow without any effect.
    if (std::abs(current) < settings_.current_limit) integral_ += more;
    return current;
  }

  /// \param torque  to be given to the joint [N m] \param motor  measured [rad/s] \returns the current [A]
  double give(double torque, double motor) noexcept { return limited(0.0, torque, motor); }

 private:
  double limited(double feedback, double torque, double velocity) noexcept {
    const double friction = share_ * drive_.friction.torque(velocity, direction_.update(velocity), torque);
    const double current = (feedback + torque + friction) / drive_.k_a + drive_.offset;
    return std::clamp(current, -settings_.current_limit, settings_.current_limit);
  }

  TrajectorySettings settings_;
  DriveFeedForward drive_;
  double share_;
  DirectionHold direction_;
  double integral_ = 0.0;
};

}  // namespace simgap
