/// \file
/// PD control of the joints through the tendon Jacobian: a torque that draws each joint to its target,
///
///     tau = K log(R^T R_target) - D v,        J^T F = -tau - g,    F >= F_0
///
/// of a slide K and D over the square of kSlideLever; a joint that follows another is drawn by its own target, too.
/// J = dL/dq, g: what gravity, springs and lines without motors do. Of all forces that make the torque, those nearest
/// to F_0 are commanded to the muscles' force controllers (state_space_force.h); a torque that no muscles can make is
/// met as well as they can (non-negative least squares; Lawson & Hanson 1974). Ideal in that it knows the model's own
/// numbers: for studies.
#pragma once

#include <Eigen/Core>
#include <memory>
#include <span>
#include <vector>

#include "simgap/simulate/bullet_arm.h"
#include "simgap/simulate/joint_targets.h"
#include "simgap/simulate/muscle_controller.h"
#include "simgap/simulate/potential_energy.h"

namespace simgap {

class JointPositionController {
 public:
  JointPositionController(const ArmModel& model, std::shared_ptr<const JointTargets> targets,
                          const ControllerOptions& options);
  /// Forces to command at a tick, shape (muscles) [N].
  void forces(double time, const BulletArm& arm, std::span<double> forces);

 private:
  Eigen::VectorXd wantedTorque(double time, const BulletArm& arm);

  std::shared_ptr<const JointTargets> targets_;
  double stiffness_, damping_, least_force_;  ///< K [N m/rad], D [N m s/rad], F_0 [N]
  PotentialEnergy energy_;
  std::vector<JointPosition> target_, joints_;
  std::vector<double> shafts_;
};

}  // namespace simgap
