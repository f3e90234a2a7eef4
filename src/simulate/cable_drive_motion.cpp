/// Motor angle phi, joint angle theta, ratio N. Torques at the joint:
///
///   tau           = K (phi / N - theta) + D (dphi/dt / N - dtheta/dt)                       in the cable
///   N J_M d2phi   = k_a (I - I_0) - tau - tau_fr(tau, dphi/dt)                               003 eq. 2 with inertia
///   J d2theta     = tau + tau_external - W sin(theta - theta_0) - c dtheta/dt
///
/// tau_fr is a set at rest. A step of Moreau & Jean's time-stepping (Jean 1999) takes the velocity without dry friction
/// towards 0 by what dry friction can do within the step, and not beyond: what cannot break away rests exactly.
#include "simgap/simulate/cable_drive_motion.h"

#include <algorithm>
#include <cmath>

namespace simgap {

CableDriveMotion::CableDriveMotion(const CableDrive& drive)
    : drive_(drive.drive),
      ratio_(drive.control.ratio),
      motor_inertia_(drive.motor_inertia),
      stiffness_(drive.stiffness),
      damping_(drive.damping),
      inertia_(drive.inertia),
      weight_(drive.weight),
      hangs_at_(drive.hangs_at),
      viscous_(drive.viscous_friction) {}

void CableDriveMotion::reset(double joint) {
  joint_ = joint;
  joint_velocity_ = motor_velocity_ = 0.0;
  motor_ = ratio_ * (joint + weight_ * std::sin(joint - hangs_at_) / stiffness_);
}

double CableDriveMotion::cableTorque() const {
  return stiffness_ * (motor_ / ratio_ - joint_) + damping_ * (motor_velocity_ / ratio_ - joint_velocity_);
}

void CableDriveMotion::step(double current, double external, double dt) {
  const double torque = cableTorque(), per_torque = dt / (ratio_ * motor_inertia_);
  const StribeckFriction& friction = drive_.friction;
  const double free = motor_velocity_ + per_torque * (drive_.k_a * (current - drive_.offset) - torque);
  const double held = per_torque * friction.dry(motor_velocity_, torque);
  motor_velocity_ = std::copysign(std::max(std::abs(free) - held, 0.0), free) / (1.0 + per_torque * friction.k_v);
  joint_velocity_ +=
      dt / inertia_ * (torque + external - weight_ * std::sin(joint_ - hangs_at_) - viscous_ * joint_velocity_);
  motor_ += dt * motor_velocity_;
  joint_ += dt * joint_velocity_;
}

}  // namespace simgap
