#include "simgap/simulate/joint_constraint_solver.h"

#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

/// Friction of a spherical joint that would move with velocity `v` without it: the impulse f, |f| <= radius, that
/// minimises 1/2 f W f + v f. Inside the ball it stops the joint; on it, it opposes the slip W f + v. On the ball
/// f = -(W + s I)^-1 v with s >= 0 from |f| = radius, by Newton on 1/|f| (Conn, Gould & Toint 2000, section 7.3).
/// \param shift  s of the last solve, where this one begins; overwritten
Eigen::Vector3d frictionImpulse(const Eigen::Matrix3d& w, const Eigen::Vector3d& v, double radius, double& shift) {
  const Eigen::Vector3d stopping = -(w.inverse() * v);
  if (!(stopping.squaredNorm() > radius * radius)) return stopping;
  constexpr int kMaxNewtonSteps = 50;
  constexpr double kTolerance = 1e-12;
  Eigen::Vector3d impulse = stopping;
  double norm = stopping.norm();
  for (int i = 0; i < kMaxNewtonSteps; ++i) {
    const Eigen::Matrix3d inverse = (w + shift * Eigen::Matrix3d::Identity()).inverse();
    impulse = -(inverse * v);
    norm = impulse.norm();
    if (std::abs(norm - radius) <= kTolerance * radius) break;
    const double slope = impulse.dot(inverse * impulse);
    shift = std::max(0.0, shift + norm * norm / slope * (norm - radius) / radius);
  }
  return impulse * (radius / norm);
}

}  // namespace

void JointConstraintSolver::setArm(btMultiBody* body, const std::vector<Joint>& joints, const std::vector<int>& links) {
  body_ = body;
  const int n = body->getNumDofs();
  viscous_ = Eigen::VectorXd::Zero(n);
  mobility_ = Eigen::MatrixXd::Zero(n, n);
  column_ = Eigen::VectorXd::Zero(n);
  velocity_ = Eigen::VectorXd::Zero(n);
  unit_impulse_.assign(6 + n, 0.0);
  response_.assign(6 + n, 0.0);
  blocks_.clear();
  couplings_.clear();
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = joints[j];
    const int first = body->getLink(links[j]).m_dofOffset;
    blocks_.push_back(
        {first, joint.degreesOfFreedom(), links[j], joint.coulomb_friction, joint.lower_limit, joint.upper_limit});
    viscous_.segment(first, joint.degreesOfFreedom()).setConstant(joint.viscous_friction);
    if (!joint.follows()) continue;
    const int leader = links[joint.leader];
    couplings_.push_back(
        {first, body->getLink(leader).m_dofOffset, links[j], leader, joint.coupling_ratio, joint.coupling_offset});
  }
}

void JointConstraintSolver::reset() {
  for (Block& block : blocks_) {
    block.friction.setZero();
    block.limit = 0.0;
    block.shift = 0.0;
  }
  for (Coupling& coupling : couplings_) coupling.impulse = 0.0;
}

void JointConstraintSolver::solve(double step_s) {
  const Eigen::Map<const Eigen::VectorXd> before(body_->getVelocityVector() + 6, velocity_.size());
  velocity_ = before;
  assembleMobility();
  addViscousFriction(step_s);
  solveBlocks(step_s);
  Eigen::Map<Eigen::VectorXd>(response_.data() + 6, velocity_.size()) = velocity_ - before;
  body_->applyDeltaVeeMultiDof(response_.data(), 1.0);
}

void JointConstraintSolver::addFrictionAndLimits(const Eigen::MatrixXd& mobility, Eigen::VectorXd& velocity,
                                                 double step_s) {
  mobility_ = mobility;
  velocity_ = velocity;
  solveBlocks(step_s);
  velocity = velocity_;
}

void JointConstraintSolver::assembleMobility() {
  const auto n = velocity_.size();
  for (Eigen::Index i = 0; i < n; ++i) {
    unit_impulse_[6 + i] = 1.0;
    body_->calcAccelerationDeltasMultiDof(unit_impulse_.data(), response_.data(), scratch_scalars_, scratch_vectors_);
    unit_impulse_[6 + i] = 0.0;
    mobility_.col(i) = Eigen::Map<const Eigen::VectorXd>(response_.data() + 6, n);
  }
  std::fill_n(response_.begin(), 6, 0.0);  // the base is fixed
}

void JointConstraintSolver::addViscousFriction(double step_s) {
  // (M + dt c e e^T)^-1 for one coordinate after the other, by Sherman & Morrison; v = W p goes along.
  for (Eigen::Index i = 0; i < velocity_.size(); ++i) {
    const double c = step_s * viscous_[i];
    if (c == 0.0) continue;
    column_ = mobility_.col(i);
    const double gain = c / (1.0 + c * column_[i]);
    velocity_ -= gain * velocity_[i] * column_;
    for (Eigen::Index j = 0; j < velocity_.size(); ++j) mobility_.col(j) -= gain * column_[j] * column_;
  }
}

void JointConstraintSolver::solveBlocks(double step_s) {
  // Last step's impulses are the best guess: an arm at rest needs the same ones again.
  for (Block& block : blocks_) {
    Eigen::Vector3d impulse = block.friction;
    impulse[0] += block.limit;
    applyImpulse(block, impulse);
  }
  for (const Coupling& coupling : couplings_) applyImpulse(coupling, coupling.impulse);
  constexpr int kMaxSweeps = 100;
  constexpr double kTolerance = 1e-11;  // [rad/s], velocity that a sweep still changes
  for (int sweep = 0; sweep < kMaxSweeps; ++sweep) {
    double change = 0.0;
    for (Block& block : blocks_) {
      if (block.coulomb > 0.0) change = std::max(change, solveFriction(block, step_s));
      if (block.size == 1) change = std::max(change, solveLimit(block, step_s));
    }
    for (Coupling& coupling : couplings_) change = std::max(change, solveCoupling(coupling, step_s));
    if (!(change > kTolerance)) return;
  }
}

double JointConstraintSolver::solveFriction(Block& block, double step_s) {
  const double radius = block.coulomb * step_s;
  Eigen::Vector3d change = Eigen::Vector3d::Zero();
  if (block.size == 1) {
    const double w = mobility_(block.first, block.first);
    change[0] = std::clamp(block.friction[0] - velocity_[block.first] / w, -radius, radius) - block.friction[0];
  } else {
    const Eigen::Matrix3d w = mobility_.block<3, 3>(block.first, block.first);
    const Eigen::Vector3d without = velocity_.segment<3>(block.first) - w * block.friction;
    change = frictionImpulse(w, without, radius, block.shift) - block.friction;
  }
  block.friction += change;
  return applyImpulse(block, change);
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
  return applyImpulse(block, Eigen::Vector3d(change, 0.0, 0.0));
}

double JointConstraintSolver::solveCoupling(Coupling& c, double step_s) {
  const double apart = body_->getJointPos(c.link) - c.offset - c.ratio * body_->getJointPos(c.leader_link);
  const double w = mobility_(c.first, c.first) - 2.0 * c.ratio * mobility_(c.first, c.leader) +
                   c.ratio * c.ratio * mobility_(c.leader, c.leader);
  const double change = -(velocity_[c.first] - c.ratio * velocity_[c.leader] + apart / step_s) / w;
  c.impulse += change;
  return applyImpulse(c, change);
}

double JointConstraintSolver::applyImpulse(const Coupling& c, double impulse) {
  column_ = impulse * (mobility_.col(c.first) - c.ratio * mobility_.col(c.leader));
  velocity_ += column_;
  return column_.lpNorm<Eigen::Infinity>();
}

double JointConstraintSolver::applyImpulse(const Block& block, const Eigen::Vector3d& impulse) {
  column_.setZero();
  for (int i = 0; i < block.size; ++i) column_ += impulse[i] * mobility_.col(block.first + i);
  velocity_ += column_;
  return column_.lpNorm<Eigen::Infinity>();
}

}  // namespace simgap
