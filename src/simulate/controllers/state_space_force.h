/// \file
/// State-space control of the line's force (000 section VII): state feedback on what an observer says of the linearised
/// motor, gearbox and cord (000 eq. 3, 8-12) while the path does not move,
///
///     L di/dt = V - R i - K_E w,    J dw/dt = N eta K_T i - b w - r F - T,    de/dt = r w / N,    F = k e + D de/dt
///
/// x = (i, w, e): current, motor velocity, expansion of the cord; T: what the model does not know, mostly Coulomb
/// friction. The observer corrects (x, T) by the measured force, T taken as constant: it acts as an integrator, so that
/// no force is missing at rest. Both sets of poles are placed in discrete time, z = exp(-rate dt), by Ackermann's
/// formula (Franklin, Powell & Workman 1998, chapters 8 and 9).
#pragma once

#include <Eigen/Dense>

#include "simgap/simulate/muscle_controller.h"

namespace simgap {

class StateSpaceForceController : public MuscleController {
 public:
  StateSpaceForceController(const Muscle& muscle, const ControllerOptions& options);
  void reset() override;
  double voltage(double command, const MuscleSensors& sensors) override;

  const Eigen::RowVector3d& feedback() const { return feedback_; }  ///< K [V/A, V s, V/m]
  const Eigen::Vector4d& observer() const { return observer_; }     ///< of (i, w, e, T) [A/N, rad/s/N, m/N, N m/N]

 private:
  Eigen::Matrix4d transition_;  ///< of (x, T) over a tick
  Eigen::Vector4d input_;       ///< by the voltage
  Eigen::RowVector4d output_;   ///< F of (x, T)
  Eigen::RowVector3d feedback_;
  Eigen::Vector4d observer_;
  double resistance_, torque_per_ampere_, radius_, stiffness_, supply_, ratio_, period_;
  Eigen::Vector4d state_ = Eigen::Vector4d::Zero();
  double last_voltage_ = 0.0, last_shaft_ = 0.0;
  bool started_ = false;
};

}  // namespace simgap
