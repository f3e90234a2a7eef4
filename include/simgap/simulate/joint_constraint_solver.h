/// \file
/// Joint friction and joint limits of a multibody of Bullet's.
///
/// Bullet's own joint motors and limits are solved row by row with a fixed number of sweeps, which does not settle
/// where a limit and a friction motor meet, and its spherical motor clamps each axis, so that friction can reach
/// sqrt(3) tau_max (docs/simulation.md). Here the same constraints, a motor with target velocity 0 and a maximum
/// torque (000 section III-B2) and a one-sided limit, are solved in joint coordinates, each joint exactly and all
/// joints by sweeps until nothing changes:
///
///     v = W (p + sum of impulses),  W = (M + dt C)^-1     viscous impulse -C v dt at the new velocity (000 eq. 1)
///     |friction impulse of a joint| <= tau_max dt;  opposes v where it slips, holds v = 0 where it can
///     limit impulse >= 0,  v >= (limit - q) / dt
///     a joint that follows: v - ratio v_leader = -(q - offset - ratio q_leader) / dt
///
/// 000 takes the viscous impulse at the old velocity; at the new one it is stable for any inertia and step.
#pragma once

#include <Eigen/Dense>
#include <vector>

#include "simgap/model/arm/arm.h"
#include "simgap/simulate/bullet.h"

namespace simgap {

class JointConstraintSolver {
 public:
  /// Called once, after the multibody is complete.
  /// \param links  link of the multibody that each joint moves, shape (joints).
  void setArm(btMultiBody* body, const std::vector<Joint>& joints, const std::vector<int>& links);

  /// Forgets the impulses of earlier steps, so that what follows depends on the state alone.
  void reset();

  /// Adds the impulses of a step to the multibody's velocity; its accelerations are computed.
  void solve(double step_s);

  /// Adds the impulses of friction and limits to a velocity that has everything else already.
  /// \param mobility  W, shape (n, n)  \param[in,out] velocity  shape (n) [rad/s]
  void addFrictionAndLimits(const Eigen::MatrixXd& mobility, Eigen::VectorXd& velocity, double step_s);

 private:
  /// A joint's coordinates and the impulses that act on it.
  struct Block {
    int first;  ///< of its coordinates
    int size;   ///< 3 spherical, else 1
    int link;
    double coulomb;                                      ///< tau_max [N m]
    double lower, upper;                                 ///< [rad]
    Eigen::Vector3d friction = Eigen::Vector3d::Zero();  ///< [N m s]
    double limit = 0.0;                                  ///< [N m s], positive pushes up from the lower limit
    double shift = 0.0;                                  ///< of the last slip, see frictionImpulse
  };

  /// A joint that follows another, and the impulse that makes it.
  struct Coupling {
    int first, leader;      ///< coordinates of both
    int link, leader_link;  ///< of the multibody
    double ratio, offset;
    double impulse = 0.0;  ///< [N m s]
  };

  void assembleMobility();
  void addViscousFriction(double step_s);
  void solveBlocks(double step_s);
  /// \returns the largest change of a velocity [rad/s]
  double solveFriction(Block& block, double step_s);
  double solveLimit(Block& block, double step_s);
  double solveCoupling(Coupling& coupling, double step_s);
  double applyImpulse(const Block& block, const Eigen::Vector3d& impulse);
  double applyImpulse(const Coupling& coupling, double impulse);

  btMultiBody* body_ = nullptr;
  std::vector<Block> blocks_;
  std::vector<Coupling> couplings_;
  Eigen::VectorXd viscous_;                      ///< shape (n) [N m s]
  Eigen::MatrixXd mobility_;                     ///< W, shape (n, n)
  Eigen::VectorXd velocity_;                     ///< v, shape (n) [rad/s]
  Eigen::VectorXd column_;                       ///< scratch, shape (n)
  std::vector<double> unit_impulse_, response_;  ///< shape (6 + n), as Bullet wants them
  btAlignedObjectArray<btScalar> scratch_scalars_;
  btAlignedObjectArray<btVector3> scratch_vectors_;
};

}  // namespace simgap
