#include "simgap/simulate/joint_constraint_solver.h"

#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

/// Friction of one joint that would move with velocity `v` without it: the impulse f, |f| <= radius, that minimises
/// 1/2 f W f + v f. Inside the ball it stops the joint; on it, it opposes the slip W f + v.
/// On the ball f = -(W + s I)^-1 v with s >= 0 from |f| = radius, found by Newton on 1/|f| (Conn, Gould & Toint 2000,
/// section 7.3), which converges from the left in a few steps.
template <int N>
Eigen::Matrix<double, N, 1> frictionImpulse(const Eigen::Matrix<double, N, N>& w, const Eigen::Matrix<double, N, 1>& v,
                                            double radius) {
  using Vector = Eigen::Matrix<double, N, 1>;
  using Matrix = Eigen::Matrix<double, N, N>;
  Vector impulse = -w.llt().solve(v);
  double norm = impulse.norm();
  if (!(norm > radius)) return impulse;
  double shift = 0.0;
  constexpr int kMaxNewtonSteps = 30;
  constexpr double kTolerance = 1e-12;
  for (int i = 0; i < kMaxNewtonSteps && std::abs(norm - radius) > kTolerance * radius; ++i) {
    const Eigen::LLT<Matrix> factor(w + shift * Matrix::Identity());
    impulse = -factor.solve(v);
    norm = impulse.norm();
    const Vector half = factor.matrixL().solve(impulse);
    shift = std::max(0.0, shift + (norm * norm / half.squaredNorm()) * (norm - radius) / radius);
  }
  return impulse * (radius / norm);
}

}  // namespace

void JointConstraintSolver::setArm(btMultiBody* body, const std::vector<Joint>& joints, const std::vector<int>& links) {
  body_ = body;
  const int n = body->getNumDofs();
  viscous_ = Eigen::VectorXd::Zero(n);
  mobility_ = implicit_ = Eigen::MatrixXd::Zero(n, n);
  factorised_ = Eigen::PartialPivLU<Eigen::MatrixXd>(n);
  velocity_ = Eigen::VectorXd::Zero(n);
  unit_impulse_.assign(6 + n, 0.0);
  response_.assign(6 + n, 0.0);
  blocks_.clear();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = joints[j];
    const int first = body->getLink(links[j]).m_dofOffset;
    blocks_.push_back({first, joint.degreesOfFreedom(), links[j], joint.coulomb_friction, joint.lower_limit,
                       joint.upper_limit});
    viscous_.segment(first, joint.degreesOfFreedom()).setConstant(joint.viscous_friction);
  }
  any_viscous_ = (viscous_.array() > 0.0).any();
}

void JointConstraintSolver::reset() {
  for (Block& block : blocks_) {
    block.friction.setZero();
    block.limit = 0.0;
  }
}

void JointConstraintSolver::solveMultiBodyGroup(btCollisionObject**, int, btPersistentManifold**, int,
                                                btTypedConstraint**, int, btMultiBodyConstraint**, int,
                                                const btContactSolverInfo& info, btIDebugDraw*, btDispatcher*) {
  const Eigen::Map<const Eigen::VectorXd> before(body_->getVelocityVector() + 6, velocity_.size());
  assembleMobility(info.m_timeStep);
  velocity_ = before;
  if (any_viscous_) {
    factorised_.compute(implicit_);
    velocity_ = factorised_.solve(velocity_).eval();
    mobility_ = factorised_.solve(mobility_).eval();
  }
  solveBlocks(info.m_timeStep);
  Eigen::Map<Eigen::VectorXd>(response_.data() + 6, velocity_.size()) = velocity_ - before;
  body_->applyDeltaVeeMultiDof(response_.data(), 1.0);
}

void JointConstraintSolver::assembleMobility(double step_s) {
  const auto n = velocity_.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    unit_impulse_[6 + i] = 1.0;
    body_->calcAccelerationDeltasMultiDof(unit_impulse_.data(), response_.data(), scratch_scalars_, scratch_vectors_);
    unit_impulse_[6 + i] = 0.0;
    mobility_.col(i) = Eigen::Map<const Eigen::VectorXd>(response_.data() + 6, n);
  }
  std::fill_n(response_.begin(), 6, 0.0);  // the base is fixed
  if (any_viscous_) {
    implicit_.noalias() = step_s * mobility_ * viscous_.asDiagonal();
    implicit_.diagonal().array() += 1.0;
  }
}

void JointConstraintSolver::solveBlocks(double step_s) {
  // Last step's impulses are the best guess: an arm at rest needs the same ones again.
  for (Block& block : blocks_) {
    Eigen::Vector3d impulse = block.friction;
    impulse[0] += block.limit;
    applyImpulse(block, impulse);
  }
  constexpr int kMaxSweeps = 100;
  constexpr double kTolerance = 1e-13;  // [rad/s], velocity that a sweep still changes
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    double change = 0.0;
    for (Block& block : blocks_) {
      if (block.coulomb > 0.0) change = std::max(change, solveFriction(block, step_s));
      if (block.size == 1) change = std::max(change, solveLimit(block, step_s));
    }
    if (!(change > kTolerance)) return;
  }
}

double JointConstraintSolver::solveFriction(Block& block, double step_s) {
  const double radius = block.coulomb * step_s;
  Eigen::Vector3d impulse = Eigen::Vector3d::Zero();
  if (block.size == 1) {
    const double w = mobility_(block.first, block.first);
    impulse[0] = std::clamp(block.friction[0] - velocity_[block.first] / w, -radius, radius);
  } else {
    const Eigen::Matrix3d w = mobility_.block<3, 3>(block.first, block.first);
    const Eigen::Vector3d without = velocity_.segment<3>(block.first) - w * block.friction;
    impulse = frictionImpulse<3>(w, without, radius);
  }
  const Eigen::Vector3d change = impulse - block.friction;
  block.friction = impulse;
  const double before = velocity_.segment(block.first, block.size).norm();
  applyImpulse(block, change);
  return std::abs(velocity_.segment(block.first, block.size).norm() - before);
}

double JointConstraintSolver::solveLimit(Block& block, double step_s) {
  const double angle = body_->getJointPos(block.link);
  const double w = mobility_(block.first, block.first);
  const double without = velocity_[block.first] - w * block.limit;
  // One of the two at most is in reach within a step; an angle beyond its limit returns with the same rule.
  double impulse = 0.0;
  if (without < (block.lower - angle) / step_s) impulse = ((block.lower - angle) / step_s - without) / w;
  if (without > (block.upper - angle) / step_s) impulse = ((block.upper - angle) / step_s - without) / w;
  const double change = impulse - block.limit;
  block.limit = impulse;
  applyImpulse(block, Eigen::Vector3d(change, 0.0, 0.0));
  return std::abs(w * change);
}

void JointConstraintSolver::applyImpulse(const Block& block, const Eigen::Vector3d& impulse) {
  velocity_.noalias() += mobility_.middleCols(block.first, block.size) * impulse.head(block.size);
}

}  // namespace simgap
