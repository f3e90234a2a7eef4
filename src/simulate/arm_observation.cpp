#include "simgap/simulate/arm_observation.h"

#include <algorithm>
#include <cmath>

#include "simgap/simulate/equilibrium_arm.h"

namespace simgap {
namespace {

constexpr double kStill = 1e-9;  // [rad]: a joint that the shafts do not move has no side to come from

/// d twist about `axis` / dw when q goes to q exp(w).
Eigen::RowVector3d twistSlope(const Eigen::Quaterniond& q, const Eigen::Vector3d& axis) {
  const Eigen::Vector3d v = q.vec();
  const double s = v.dot(axis);
  const Eigen::Vector3d ds = 0.5 * (q.w() * axis + axis.cross(v));
  return 2.0 * (q.w() * ds + 0.5 * s * v).transpose() / (q.w() * q.w() + s * s);
}

}  // namespace

void ArmObservation::setModel(const ArmModel& model) {
  if (model.extensions.empty() && extensions_.empty()) return;
  extensions_.clear();
  markers_ = sticks_ = false;
  const std::vector<ArmExtension> all = resolveExtensions(model);
  for (std::size_t e = 0; e < all.size(); ++e) {
    if (all[e].effect->marker_turn || all[e].effect->stiction) extensions_.push_back({static_cast<int>(e), all[e]});
    markers_ |= all[e].effect->marker_turn != nullptr;
    sticks_ |= all[e].effect->stiction != nullptr;
  }
  joints_ = model.joints;
}

Eigen::Vector3d ArmObservation::markerTurn(int body) const {
  Eigen::Vector3d turn = Eigen::Vector3d::Zero();
  for (const auto& [index, extension] : extensions_) {
    const auto hook = extension.effect->marker_turn;
    if (hook && extension.target == body) turn += hook(extension.p);
  }
  return turn;
}

void ArmObservation::turnMarkers(std::vector<JointPosition>& joints) const {
  for (std::size_t j = 0; markers_ && j < joints_.size(); ++j) {
    joints[j] =
        markedPosition(joints_[j], joints[j], joints_[j].parent_orientation.conjugate() * markerTurn(joints_[j].parent),
                       joints_[j].child_orientation.conjugate() * markerTurn(joints_[j].child));
  }
}

/// The side that each stiction holds its joint on, a unit torque. \returns what they hold together
Eigen::VectorXd ArmObservation::findSides(EquilibriumArm& arm, std::span<const double> shafts,
                                          std::span<const double> shafts_before) {
  arm.linearise();
  const Eigen::Map<const Eigen::VectorXd> now(shafts.data(), std::ssize(shafts));
  Eigen::MatrixXd way(arm.energy().degreesOfFreedom(), std::ssize(shafts));  // minus dq/dphi
  arm.energy().differentiateByShafts(way);
  arm.applyInverseHessian(way);
  Eigen::VectorXd torque = Eigen::VectorXd::Zero(way.rows());
  for (std::size_t k = 0; k < extensions_.size(); ++k) {
    const ArmExtension& extension = extensions_[k].extension;
    if (!extension.effect->stiction) continue;
    const Stiction stiction = extension.effect->stiction(extension.p);
    Eigen::VectorXd wound = now;
    if (stiction.from_previous && !shafts_before.empty()) {
      wound -= Eigen::Map<const Eigen::VectorXd>(shafts_before.data(), std::ssize(shafts_before));
    }
    const int d = arm.energy().firstDof(extension.target);
    const int components = joints_[extension.target].degreesOfFreedom();
    const Eigen::VectorXd back = (way * wound).segment(d, components);
    if (back.norm() < kStill) continue;
    sides_[k].segment(d, components) = back.normalized();
    torque += stiction.torque * sides_[k];
  }
  return torque;
}

void ArmObservation::observe(EquilibriumArm& arm, std::span<const double> shafts, std::span<const double> shafts_before,
                             std::vector<JointPosition>& joints) {
  const int n = arm.energy().degreesOfFreedom();
  sides_.assign(extensions_.size(), Eigen::VectorXd::Zero(n));
  if (sticks_) {
    const Eigen::VectorXd torque = findSides(arm, shafts, shafts_before);
    if (!arm.hold(torque)) std::ranges::fill(sides_, Eigen::VectorXd::Zero(n));
  }
  joints = arm.joints();
  bones_ = joints;
  turnMarkers(joints);
}

void ArmObservation::chain(EquilibriumArm& arm, std::span<const StaticParameter> parameters,
                           Eigen::Ref<Eigen::MatrixXd> columns) const {
  const auto columnsOf = [&](int index, auto action) {
    for (std::size_t c = 0; c < parameters.size(); ++c) {
      if (parameters[c].kind != StaticParameter::Kind::kExtension || parameters[c].item != index) continue;
      action(static_cast<Eigen::Index>(c), parameters[c].component);
    }
  };
  for (std::size_t k = 0; k < extensions_.size(); ++k) {
    if (!extensions_[k].extension.effect->stiction) continue;
    Eigen::MatrixXd lag = sides_[k];
    arm.applyInverseHessian(lag);
    columnsOf(extensions_[k].index, [&](Eigen::Index c, int) { columns.col(c) += lag.col(0); });
  }
  for (std::size_t j = 0; markers_ && j < joints_.size(); ++j) {
    const Joint& joint = joints_[j];
    const int d = arm.energy().firstDof(static_cast<int>(j));
    const bool ball = !joint.hasAxis();
    if (joint.slides()) continue;
    const Eigen::Matrix3d to_parent = joint.parent_orientation.conjugate().toRotationMatrix();
    const Eigen::Matrix3d to_child = joint.child_orientation.conjugate().toRotationMatrix();
    const Eigen::Vector3d parent_turn = to_parent * markerTurn(joint.parent);
    const Eigen::Vector3d child_turn = to_child * markerTurn(joint.child);
    const Eigen::Quaterniond bone =
        ball ? bones_[j].rotation : Eigen::Quaterniond(Eigen::AngleAxisd(bones_[j].angle, joint.axis));
    const Eigen::Matrix3d marker_from_child = expSo3(child_turn).toRotationMatrix().transpose();
    const Eigen::RowVector3d slope = twistSlope(expSo3(-parent_turn) * bone * expSo3(child_turn), joint.axis);
    if (ball) {
      columns.middleRows<3>(d) = (marker_from_child * columns.middleRows<3>(d)).eval();
    } else {
      columns.row(d) *= slope.dot(marker_from_child * joint.axis);
    }
    const auto addTurn = [&](Eigen::Index c, const Eigen::Vector3d& turn) {
      if (ball) {
        columns.col(c).segment<3>(d) += turn;
      } else {
        columns(d, c) += slope.dot(turn);
      }
    };
    const Eigen::Matrix3d by_child = rightJacobian(child_turn) * to_child;
    const Eigen::Matrix3d by_parent =
        -(bone * expSo3(child_turn)).toRotationMatrix().transpose() * rightJacobian(-parent_turn) * to_parent;
    for (const auto& [index, extension] : extensions_) {
      if (!extension.effect->marker_turn) continue;
      if (extension.target == joint.child) columnsOf(index, [&](auto c, int i) { addTurn(c, by_child.col(i)); });
      if (extension.target == joint.parent) columnsOf(index, [&](auto c, int i) { addTurn(c, by_parent.col(i)); });
    }
  }
}

}  // namespace simgap
