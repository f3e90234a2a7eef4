#include "state_space_force.h"

#include <algorithm>
#include <cmath>
#include <unsupported/Eigen/MatrixFunctions>

namespace simgap {
namespace {

/// Coefficients of prod (z - z_i), of z^0 … z^n.
template <int N>
std::array<double, N + 1> polynomial(const std::array<double, N>& rates, double period) {
  std::array<double, N + 1> c{};
  c[0] = 1.0;
  for (int n = 0; n < N; ++n) {
    const double root = std::exp(-rates[n] * period);
    for (int k = n + 1; k >= 0; --k) {
      c[k] = (k > 0 ? c[k - 1] : 0.0) - root * c[k];
    }
  }
  return c;
}

/// Ackermann: the K for which A - B K has those poles.
template <int N>
Eigen::Matrix<double, 1, N> placePoles(const Eigen::Matrix<double, N, N>& a, const Eigen::Matrix<double, N, 1>& b,
                                       const std::array<double, N>& rates, double period) {
  const auto c = polynomial<N>(rates, period);
  Eigen::Matrix<double, N, N> controllability, power = Eigen::Matrix<double, N, N>::Identity(),
                                               wanted = Eigen::Matrix<double, N, N>::Zero();
  for (int k = 0; k < N; ++k) {
    controllability.col(k) = power * b;
    wanted += c[k] * power;
    power = power * a;
  }
  wanted += power;
  const Eigen::Matrix<double, N, N> inverse = controllability.inverse();
  return inverse.row(N - 1) * wanted;
}

}  // namespace

StateSpaceForceController::StateSpaceForceController(const Muscle& muscle, const ControllerOptions& options)
    : resistance_(muscle.motor.resistance),
      torque_per_ampere_(muscle.gearbox.ratio * muscle.gearbox.efficiency * muscle.motor.torque_constant),
      radius_(muscle.spindle_radius),
      stiffness_(muscle.shock_cord.stiffness),
      supply_(muscle.motor.supply_voltage),
      ratio_(muscle.gearbox.ratio),
      period_(1.0 / options.rate) {
  const Motor& motor = muscle.motor;
  const Gearbox& gearbox = muscle.gearbox;
  const double gain = gearbox.ratio * gearbox.efficiency;
  const double inertia = gain * motor.inertia + gearbox.inertia / gearbox.ratio;
  const double viscous = gain * motor.viscous_friction + gearbox.viscous_friction / gearbox.ratio;
  const double winding = radius_ / ratio_, damping = muscle.shock_cord.damping;
  output_ << 0.0, damping * winding, stiffness_, 0.0;
  Eigen::Matrix<double, 5, 5> bordered = Eigen::Matrix<double, 5, 5>::Zero();
  bordered.row(0) << -motor.resistance, -motor.back_emf_constant, 0.0, 0.0, 1.0;
  bordered.row(0) /= motor.inductance;
  bordered.row(1) << torque_per_ampere_, -viscous, 0.0, -1.0, 0.0;
  bordered.row(1).head<4>() -= radius_ * output_;
  bordered.row(1) /= inertia;
  bordered(2, 1) = winding;
  const Eigen::Matrix<double, 5, 5> exponential = (bordered * period_).exp();
  transition_ = exponential.topLeftCorner<4, 4>();
  input_ = exponential.topRightCorner<4, 1>();
  feedback_ = placePoles<3>(transition_.topLeftCorner<3, 3>(), input_.head<3>(), options.force_rates, period_);
  observer_ = placePoles<4>(transition_.transpose(), transition_.transpose() * output_.transpose(),
                            options.observer_rates, period_)
                  .transpose();
}

void StateSpaceForceController::reset() {
  state_.setZero();
  last_voltage_ = 0.0;
  started_ = false;
}

double StateSpaceForceController::voltage(double command, const MuscleSensors& sensors) {
  if (sensors.force <= 0.0 || !started_) {
    // A slack cord says nothing of the drive: its velocity is the potentiometer's.
    const double velocity = started_ ? ratio_ * (sensors.shaft - last_shaft_) / period_ : 0.0;
    state_ << sensors.current, velocity, std::max(0.0, sensors.force) / stiffness_, 0.0;
    // Where a motion begins, the motor rests under its load, whatever holds it.
    if (sensors.force > 0.0) state_[3] = torque_per_ampere_ * sensors.current - radius_ * sensors.force;
  } else {
    const Eigen::Vector4d predicted = transition_ * state_ + input_ * last_voltage_;
    state_ = predicted + observer_ * (sensors.force - output_ * predicted);
  }
  started_ = true;
  last_shaft_ = sensors.shaft;
  // Where the wanted force rests: e = F/k, w = 0, and the current that holds it against load and T.
  const double current = (radius_ * command + state_[3]) / torque_per_ampere_;
  const Eigen::Vector3d wanted(current, 0.0, command / stiffness_);
  const double voltage = resistance_ * current - feedback_ * (state_.head<3>() - wanted);
  last_voltage_ = std::clamp(voltage, -supply_, supply_);
  return last_voltage_;
}

}  // namespace simgap
