#include "bullet_joint.h"

#include <Eigen/Eigenvalues>
#include <cmath>

#include "simgap/model/arm/ball_stop.h"

namespace simgap {

BulletLink addLink(btMultiBody& body, int index, const Joint& joint, const MassProperties& mass,
                   const BulletLink& parent) {
  Eigen::SelfAdjointEigenSolver<Eigen::Matrix3d> principal(mass.inertia);
  Eigen::Matrix3d axes = principal.eigenvectors();
  if (axes.determinant() < 0.0) axes.col(2) = -axes.col(2);
  const BulletLink child{index, mass.centre_of_mass, Eigen::Quaterniond(axes)};
  const Eigen::Quaterniond link_from_body = child.body_from_link.conjugate();

  const btVector3 inertia = toBullet(principal.eigenvalues());
  // At position 0 the joint's frames on both bodies are one.
  const Eigen::Quaterniond turn = joint.child_orientation * joint.parent_orientation.conjugate();
  const btQuaternion child_from_parent = toBullet(link_from_body * turn * parent.body_from_link);
  const btVector3 parent_to_pivot =
      toBullet(parent.body_from_link.conjugate() * (joint.parent_position - parent.centre_of_mass));
  const btVector3 pivot_to_child = toBullet(link_from_body * (child.centre_of_mass - joint.child_position));
  const btVector3 axis = toBullet(link_from_body * (joint.child_orientation * joint.axis));
  if (joint.slides()) {
    body.setupPrismatic(index, mass.mass, inertia, parent.index, child_from_parent, axis, parent_to_pivot,
                        pivot_to_child, true);
  } else if (!joint.hasAxis()) {
    body.setupSpherical(index, mass.mass, inertia, parent.index, child_from_parent, parent_to_pivot, pivot_to_child,
                        true);
  } else {
    body.setupRevolute(index, mass.mass, inertia, parent.index, child_from_parent, axis, parent_to_pivot,
                       pivot_to_child, true);
  }
  return child;
}

namespace {

Eigen::Quaterniond linkFromJoint(const Joint& joint, const BulletLink& child) {
  return child.body_from_link.conjugate() * joint.child_orientation;
}

}  // namespace

std::array<btScalar, 4> bulletPosition(const Joint& joint, const BulletLink& child, const JointPosition& position) {
  if (joint.hasAxis()) return {position.angle, 0.0, 0.0, 0.0};
  const Eigen::Quaterniond frame = linkFromJoint(joint, child);
  const Eigen::Quaterniond q = frame * position.rotation * frame.conjugate();
  return {q.x(), q.y(), q.z(), q.w()};
}

JointPosition positionOf(const Joint& joint, const BulletLink& child, const btScalar* q) {
  JointPosition position;
  if (!joint.hasAxis()) {
    const Eigen::Quaterniond frame = linkFromJoint(joint, child);
    position.rotation = frame.conjugate() * Eigen::Quaterniond(q[3], q[0], q[1], q[2]) * frame;
  } else {
    position.angle = q[0];
  }
  return position;
}

Eigen::Vector3d bulletVelocity(const Joint& joint, const BulletLink& child, const Eigen::Vector3d& velocity) {
  if (joint.hasAxis()) return velocity;
  return child.body_from_link.conjugate() * velocity;
}

Eigen::Vector3d relativeSpin(const Joint& joint, const BulletLink& child, const btScalar* velocity) {
  if (joint.slides()) return Eigen::Vector3d::Zero();
  if (joint.hasAxis()) return (joint.child_orientation * joint.axis) * velocity[0];
  return child.body_from_link * Eigen::Vector3d(velocity[0], velocity[1], velocity[2]);
}

double speed(const Joint& joint, const btScalar* v) {
  if (joint.hasAxis()) return std::abs(v[0]);
  return std::sqrt(v[0] * v[0] + v[1] * v[1] + v[2] * v[2]);
}

double springEnergy(const Joint& joint, const JointPosition& position) {
  const double stretch = joint.hasAxis() ? position.angle - joint.spring_rest : logSo3(position.rotation).norm();
  const double spring = 0.5 * joint.spring_stiffness * stretch * stretch;
  if (joint.stop.stiffness <= 0.0) return spring;
  return spring + ballStop(joint.stop, joint.axis, position.rotation).energy;
}

Eigen::Vector3d springGradient(const Joint& joint, const JointPosition& position) {
  if (joint.hasAxis()) return {joint.spring_stiffness * (position.angle - joint.spring_rest), 0.0, 0.0};
  const Eigen::Vector3d spring = joint.spring_stiffness * logSo3(position.rotation);
  if (joint.stop.stiffness <= 0.0) return spring;
  return spring + ballStop(joint.stop, joint.axis, position.rotation).gradient;
}

Eigen::Vector3d torqueInChild(const Joint& joint, const Eigen::Vector3d& torque) {
  return joint.child_orientation * (joint.hasAxis() ? Eigen::Vector3d(torque.x() * joint.axis) : torque);
}

}  // namespace simgap
