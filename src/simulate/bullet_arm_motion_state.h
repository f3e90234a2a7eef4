/// \file
/// What a step of BulletArm's motions holds.
#pragma once

#include <vector>

#include "arm_dynamics.h"
#include "bullet_arm_state.h"
#include "guide_slip.h"

namespace simgap {

struct BulletArm::Motion {
  /// A taut cord at the middle of a step: F + D J . (v - v_n) at the velocity v of the joints.
  struct Pull {
    Eigen::VectorXd row;  ///< J = dL/dq, shape (dof) [m/rad]
    double force = 0.0;   ///< F, at v_n [N]
    double damping = 0.0;
    double winding_radius = 0.0;
    bool taut = false;
  };
  ArmDynamics dynamics;
  std::vector<Pull> pulls;            ///< shape (muscles + lines without motors)
  Eigen::MatrixXd inertia, mobility;  ///< M + dt/2 (C + sum D J J^T), and its inverse
  GuideSlip guides{0, 0};
  Eigen::VectorXd viscous, v, change, next, middle, tau, bias, scratch;
  Eigen::VectorXd pushed;  ///< what friction, limits and couplings added to v in the step before

  Motion(const std::vector<Body>& bodies, const std::vector<Joint>& joints, const std::vector<BulletLink>& links,
         std::size_t lines) {
    dynamics.setArm(bodies, joints, links);
    const int n = dynamics.degreesOfFreedom();
    guides = GuideSlip(n, lines);
    inertia = mobility = Eigen::MatrixXd::Zero(n, n);
    viscous = Eigen::VectorXd::Zero(n);
    int first = 0;
    for (const Joint& joint : joints) {
      viscous.segment(first, joint.degreesOfFreedom()).setConstant(joint.viscous_friction);
      first += joint.degreesOfFreedom();
    }
    v = change = next = middle = tau = bias = scratch = pushed = Eigen::VectorXd::Zero(n);
    pulls.resize(lines);
    for (Pull& pull : pulls) pull.row = Eigen::VectorXd::Zero(n);
  }
};

}  // namespace simgap
