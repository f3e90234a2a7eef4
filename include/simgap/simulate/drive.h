/// \file
/// DC motor and gearbox as one state-space model (000 eq. 8-11), integrated exactly over a step:
///
///     L di/dt     = V - R i - K_E w
///     J dw/dt     = N eta K_T i - b w - c sign(w) - T,      J = N eta J_M + J_G / N
///     dphi/dt     = w / N                                   b = N eta mu_M + mu_G / N,  c = N eta tau_CM + tau_CG
///
/// w: motor velocity, phi: shaft angle, T: load torque at the spindle. 000 used a forward Euler step; L/R is of the
/// order of a physics step here, where Euler would not be stable. Voltage and load are constant over a step.
#pragma once

#include <Eigen/Core>

#include "simgap/model/arm/arm.h"

namespace simgap {

struct DriveState {
  double current = 0.0;         ///< i [A]
  double motor_velocity = 0.0;  ///< w [rad/s]
  double shaft_angle = 0.0;     ///< phi [rad], positive winds the line up
};

/// The model of one drive for one step size.
class Drive {
 public:
  Drive(const Motor& motor, const Gearbox& gearbox, double step_s);

  /// Advances one step. At rest the Coulomb torque holds up to its limit; a velocity that changes its sign within
  /// the step ends at 0.
  /// \param voltage  [V]  \param load  torque of the line at the spindle [N m], positive unwinds.
  void step(DriveState& state, double voltage, double load) const noexcept;
  /// As step(), but a rotor that turns goes on from the moment at which it stood: of second order. Arms do without:
  /// their motions are fitted worse with it, and nobody knows yet why.
  void stepThrough(DriveState& state, double voltage, double load) const noexcept;

  double ratio() const { return ratio_; }

 private:
  void move(DriveState& state, double voltage, double opposing_torque) const noexcept;
  /// \returns [s] what is left of the step when the rotor came to rest within it
  double advance(DriveState& state, double voltage, double load) const noexcept;

  Eigen::Matrix3d transition_;         ///< of (i, w, phi)
  Eigen::Matrix<double, 3, 2> input_;  ///< of (V, -opposing torque)
  double rest_decay_;                  ///< exp(-R dt / L): current while the rotor stands
  double conductance_;                 ///< 1 / R
  double torque_per_ampere_;
  double coulomb_torque_;
  double inertia_;  ///< J
  double ratio_;
  double step_;
};

}  // namespace simgap
