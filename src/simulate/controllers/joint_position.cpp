#include "joint_position.h"

#include <algorithm>
#include <cmath>

#include "simgap/core/joint_kind.h"
#include "simgap/core/rotation.h"

namespace simgap {
namespace {

/// min |A x - b|^2 + small |x|^2, x >= 0, coordinate after coordinate until none moves.
Eigen::VectorXd nonNegative(const Eigen::MatrixXd& a, const Eigen::VectorXd& b) {
  constexpr double kSmall = 1e-3;  // of the mean diagonal: which of many solutions
  constexpr int kSweeps = 200;
  Eigen::MatrixXd normal = a.transpose() * a;
  normal.diagonal().array() += kSmall * normal.diagonal().mean() + 1e-12;
  const Eigen::VectorXd right = a.transpose() * b;
  Eigen::VectorXd x = Eigen::VectorXd::Zero(a.cols());
  for (int sweep = 0; sweep < kSweeps; ++sweep) {
    double change = 0.0;
    for (Eigen::Index i = 0; i < x.size(); ++i) {
      const double next = std::max(0.0, x[i] + (right[i] - normal.row(i).dot(x)) / normal(i, i));
      change = std::max(change, std::abs(next - x[i]));
      x[i] = next;
    }
    if (change < 1e-4) break;
  }
  return x;
}

/// What turns a joint that follows another turns its leader, times their ratio: rows of followers go into those of
/// their leaders. \param[in,out] wanted  shape (dof)  \param[in,out] arms  shape (dof, muscles)
void foldFollowers(const PotentialEnergy& energy, Eigen::VectorXd& wanted, Eigen::MatrixXd& arms) {
  const std::vector<Joint>& joints = energy.model().joints;
  for (auto j = std::ssize(joints) - 1; j >= 0; --j) {
    const Joint& joint = joints[j];
    if (!joint.follows()) continue;
    const int own = energy.firstDof(static_cast<int>(j)), leader = energy.firstDof(joint.leader);
    wanted[leader] += joint.coupling_ratio * wanted[own];
    arms.row(leader) += joint.coupling_ratio * arms.row(own);
    wanted[own] = 0.0;
    arms.row(own).setZero();
  }
}

}  // namespace

JointPositionController::JointPositionController(const ArmModel& model, std::shared_ptr<const JointTargets> targets,
                                                 const ControllerOptions& options)
    : targets_(std::move(targets)),
      stiffness_(options.joint_stiffness),
      damping_(options.joint_damping),
      least_force_(options.least_force),
      energy_(model),
      joints_(model.joints.size()),
      shafts_(model.muscles.size()) {}

Eigen::VectorXd JointPositionController::wantedTorque(double time, const BulletArm& arm) {
  const std::vector<Joint>& joints = energy_.model().joints;
  targets_->at(time, joints, target_);
  Eigen::VectorXd torque(energy_.degreesOfFreedom());
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const int first = energy_.firstDof(static_cast<int>(j));
    const Eigen::Vector3d velocity = arm.jointVelocity(j);
    if (joints[j].hasAxis()) {
      const double lever = kindOf(joints[j].type).counted;
      torque[first] = lever * lever * (stiffness_ * (target_[j].angle - joints_[j].angle) - damping_ * velocity.x());
    } else {
      const Eigen::Vector3d way = logSo3(joints_[j].rotation.conjugate() * target_[j].rotation);
      torque.segment<3>(first) = stiffness_ * way - damping_ * velocity;
    }
  }
  return torque;
}

void JointPositionController::forces(double time, const BulletArm& arm, std::span<double> forces) {
  for (std::size_t j = 0; j < joints_.size(); ++j) joints_[j] = arm.jointPosition(j);
  for (std::size_t m = 0; m < shafts_.size(); ++m) shafts_[m] = arm.shaftAngle(m);
  energy_.setShafts(shafts_);
  energy_.evaluate(joints_);
  const auto muscles = std::ssize(shafts_);
  Eigen::MatrixXd arms(energy_.degreesOfFreedom(), muscles);
  Eigen::VectorXd rest = energy_.gradient();  // becomes that of everything but the muscles
  for (Eigen::Index m = 0; m < muscles; ++m) {
    energy_.momentArms(static_cast<std::size_t>(m), arms.col(m));
    rest -= energy_.tension(static_cast<std::size_t>(m)) * arms.col(m);
  }
  Eigen::VectorXd wanted = -wantedTorque(time, arm) - rest;
  foldFollowers(energy_, wanted, arms);
  const Eigen::VectorXd more = nonNegative(arms, wanted - least_force_ * arms.rowwise().sum());
  for (Eigen::Index m = 0; m < muscles; ++m) forces[m] = least_force_ + more[m];
}

}  // namespace simgap
