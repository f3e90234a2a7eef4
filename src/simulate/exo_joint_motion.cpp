/// The one-degree-of-freedom system of 002 section III. State: theta, omega, the pressures p in the muscles, the bent
/// bristles z of both braids and of the joint's dry friction.
///
///   eps_f = eps_f0 + r0 theta / L0,   eps_e = eps_e0 - r0 theta / L0
///   f     = max(0, f_0 - h p z),  f_0 = p g(eps + f_0 / k)            002 eq. 16, friction of the braid
///   dz/dt = (d eps/dt - |d eps/dt| z) / slip                          Dahl 1968
///   dp/dt = (clamp(p_ref, 0, supply) - p) / T                         valve and filling
///   J d omega/dt = (f_f - f_e) r0 + N eta K_t i + tau_external - W sin(theta - theta_0) - c omega - tau_c z_c + stops
///   J = J_link + N^2 J_M,   c = c_link + N^2 mu_M,   tau_c = tau_link + N tau_CM
#include "simgap/simulate/exo_joint_motion.h"

#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

constexpr double kDrySlip = 1e-3;         // [rad] over which the joint's dry friction turns round
constexpr double kStopFrequency = 200.0;  // [rad/s] of the joint against its elastic stop

/// Bristles that are dragged along and bend before they slip (Dahl 1968).
double bending(double rate, double bent, double slip) { return (rate - std::abs(rate) * bent) / slip; }

}  // namespace

ExoJointMotion::ExoJointMotion(const ExoJoint& joint)
    : joint_(joint),
      inertia_(joint.link.inertia),
      coulomb_(joint.link.coulomb_friction),
      viscous_(joint.link.viscous_friction) {
  if (!joint.motor) return;
  const ExoMotor& motor = *joint.motor;
  inertia_ += motor.ratio * motor.ratio * motor.inertia;
  viscous_ += motor.ratio * motor.ratio * motor.viscous_friction;
  coulomb_ += motor.ratio * motor.coulomb_friction;
}

double ExoJointMotion::flexorForce(const State& s) const {
  const double p = s[kFlexorPressure];
  return std::max(0.0, joint_.muscles.flexorForce(p, s[kAngle]) - joint_.hysteresis * p * s[kFlexorBristle]);
}

double ExoJointMotion::extensorForce(const State& s) const {
  const double p = s[kExtensorPressure];
  return std::max(0.0, joint_.muscles.extensorForce(p, s[kAngle]) - joint_.hysteresis * p * s[kExtensorBristle]);
}

double ExoJointMotion::muscleTorque(const State& s) const {
  return (flexorForce(s) - extensorForce(s)) * joint_.muscles.radius;
}

double ExoJointMotion::motorTorque(double current) const {
  if (!joint_.motor) return 0.0;
  const double limit = joint_.motor->current_limit;
  return joint_.motor->torquePerAmpere() * std::clamp(current, -limit, limit);
}

/// Springs with critical damping that only push back.
double ExoJointMotion::stopTorque(const State& s) const {
  const double beyond = s[kAngle] - std::clamp(s[kAngle], joint_.link.lower, joint_.link.upper);
  if (beyond == 0.0) return 0.0;
  const double torque = -inertia_ * kStopFrequency * (kStopFrequency * beyond + 2.0 * s[kVelocity]);
  return beyond > 0.0 ? std::min(0.0, torque) : std::max(0.0, torque);
}

ExoJointMotion::State ExoJointMotion::derivative(const State& s, const Inputs& in) const {
  const double omega = s[kVelocity], contracting = joint_.muscles.radius * omega / joint_.muscles.length;
  const double torque = muscleTorque(s) + motorTorque(in.current) + in.external -
                        joint_.link.weight * std::sin(s[kAngle] - joint_.link.hangs_at) - viscous_ * omega -
                        coulomb_ * s[kDryBristle] + stopTorque(s);
  const auto filling = [&](double reference, double p) {
    return (std::clamp(reference, 0.0, joint_.supply) - p) / joint_.valve_time;
  };
  State rate;
  rate[kAngle] = omega;
  rate[kVelocity] = torque / inertia_;
  rate[kFlexorPressure] = filling(in.flexor_pressure, s[kFlexorPressure]);
  rate[kExtensorPressure] = filling(in.extensor_pressure, s[kExtensorPressure]);
  rate[kFlexorBristle] = bending(contracting, s[kFlexorBristle], joint_.slip);
  rate[kExtensorBristle] = bending(-contracting, s[kExtensorBristle], joint_.slip);
  rate[kDryBristle] = bending(omega, s[kDryBristle], kDrySlip);
  return rate;
}

void ExoJointMotion::reset(double angle, const Inputs& inputs) {
  state_.setZero();
  state_[kAngle] = angle;
  state_[kFlexorPressure] = std::clamp(inputs.flexor_pressure, 0.0, joint_.supply);
  state_[kExtensorPressure] = std::clamp(inputs.extensor_pressure, 0.0, joint_.supply);
}

void ExoJointMotion::step(const Inputs& inputs, double h) {
  const State k1 = derivative(state_, inputs);
  const State k2 = derivative(state_ + 0.5 * h * k1, inputs);
  const State k3 = derivative(state_ + 0.5 * h * k2, inputs);
  const State k4 = derivative(state_ + h * k3, inputs);
  state_ += h / 6.0 * (k1 + 2.0 * k2 + 2.0 * k3 + k4);
}

}  // namespace simgap
