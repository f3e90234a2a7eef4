#include "simgap/simulate/drive.h"

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

namespace simgap {

Drive::Drive(const Motor& motor, const Gearbox& gearbox, double step_s)
    : rest_decay_(std::exp(-motor.resistance * step_s / motor.inductance)),
      conductance_(1.0 / motor.resistance),
      torque_per_ampere_(gearbox.ratio * gearbox.efficiency * motor.torque_constant),
      coulomb_torque_(gearbox.ratio * gearbox.efficiency * motor.coulomb_friction + gearbox.coulomb_friction),
      inertia_(gearbox.ratio * gearbox.efficiency * motor.inertia + gearbox.inertia / gearbox.ratio),
      ratio_(gearbox.ratio),
      step_(step_s) {
  const double gain = gearbox.ratio * gearbox.efficiency;
  const double damping = gain * motor.viscous_friction + gearbox.viscous_friction / gearbox.ratio;
  // exp of the state matrix bordered by its inputs gives the transition and the response to constant inputs together.
  Eigen::Matrix<double, 5, 5> bordered = Eigen::Matrix<double, 5, 5>::Zero();
  bordered.row(0) << -motor.resistance, -motor.back_emf_constant, 0.0, 1.0, 0.0;
  bordered.row(0) /= motor.inductance;
  bordered.row(1) << torque_per_ampere_, -damping, 0.0, 0.0, 1.0;
  bordered.row(1) /= inertia_;
  bordered(2, 1) = 1.0 / gearbox.ratio;
  const Eigen::Matrix<double, 5, 5> exponential = (bordered * step_s).exp();
  transition_ = exponential.topLeftCorner<3, 3>();
  input_ = exponential.topRightCorner<3, 2>();
}

void Drive::move(DriveState& state, double voltage, double opposing_torque) const noexcept {
  const Eigen::Vector3d x(state.current, state.motor_velocity, state.shaft_angle);
  const Eigen::Vector3d next = transition_ * x + input_ * Eigen::Vector2d(voltage, -opposing_torque);
  state = {next[0], next[1], next[2]};
}

void Drive::step(DriveState& state, double voltage, double load) const noexcept { advance(state, voltage, load); }

void Drive::stepThrough(DriveState& state, double voltage, double load) const noexcept {
  const DriveState before = state;
  const double rest = advance(state, voltage, load);
  // The rest of the step begins at rest: held, or off the other way by what exceeds the Coulomb torque. Without it each
  // turn is late, and a fit takes that for less inertia.
  const double torque = torque_per_ampere_ * state.current - load;
  const double net = torque - std::clamp(torque, -coulomb_torque_, coulomb_torque_);
  if (rest == 0.0 || net * before.motor_velocity >= 0.0) return;
  state.motor_velocity = net / inertia_ * rest;
  state.shaft_angle += 0.5 * state.motor_velocity * rest / ratio_;
}

double Drive::advance(DriveState& state, double voltage, double load) const noexcept {
  const DriveState before = state;
  if (coulomb_torque_ == 0.0) {
    move(state, voltage, load);
    return 0.0;
  }
  if (state.motor_velocity == 0.0) {
    const double standing = conductance_ * voltage;
    state.current = standing + (state.current - standing) * rest_decay_;
    const double torque = torque_per_ampere_ * state.current - load;
    if (std::abs(torque) <= coulomb_torque_) return 0.0;
    DriveState moved = before;
    move(moved, voltage, load + std::copysign(coulomb_torque_, torque));
    // A current that only just rises past the limit may not yet have moved the rotor the right way.
    if (std::signbit(moved.motor_velocity) == std::signbit(torque)) state = moved;
    return 0.0;
  }
  move(state, voltage, load + std::copysign(coulomb_torque_, before.motor_velocity));
  if (std::signbit(state.motor_velocity) == std::signbit(before.motor_velocity)) return 0.0;
  // Stopped within the step: at constant deceleration, after the fraction of it at which the velocity was 0.
  const double fraction = before.motor_velocity / (before.motor_velocity - state.motor_velocity);
  state.shaft_angle = before.shaft_angle + 0.5 * before.motor_velocity * fraction * step_ / ratio_;
  state.motor_velocity = 0.0;
  return (1.0 - fraction) * step_;
}

}  // namespace simgap
