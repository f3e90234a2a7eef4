/// \file
/// How Bullet's multibody holds a joint, and back: the only place that knows both.
#pragma once

#include <array>

#include "simgap/model/arm/arm.h"
#include "simgap/simulate/bullet.h"

namespace simgap {

/// A body's place in the multibody. Bullet wants link frames at the centre of mass along the principal axes.
struct BulletLink {
  int index = -1;                                            ///< -1: a fixed body, the multibody's base
  Eigen::Vector3d centre_of_mass = Eigen::Vector3d::Zero();  ///< in the body's frame
  Eigen::Quaterniond body_from_link = Eigen::Quaterniond::Identity();
};

/// Adds the joint's child to the multibody. \returns its place.
BulletLink addLink(btMultiBody& body, int index, const Joint& joint, const MassProperties& mass,
                   const BulletLink& parent);

/// \name A joint's position and velocity, in Bullet's coordinates of its child and in ours
///@{
std::array<btScalar, 4> bulletPosition(const Joint& joint, const BulletLink& child, const JointPosition& position);
JointPosition positionOf(const Joint& joint, const BulletLink& child, const btScalar* coordinates);
/// \param velocity  of a ball: in the child's frame; of a hinge: the first component [rad/s]
Eigen::Vector3d bulletVelocity(const Joint& joint, const BulletLink& child, const Eigen::Vector3d& velocity);
/// Of the child against its parent, in the child's frame [rad/s].
Eigen::Vector3d relativeSpin(const Joint& joint, const BulletLink& child, const btScalar* velocity);
double speed(const Joint& joint, const btScalar* velocity);  ///< >= 0 [rad/s], prismatic [m/s]
///@}

/// A torque in the joint's own coordinates, as a vector in the child's frame [N m].
Eigen::Vector3d torqueInChild(const Joint& joint, const Eigen::Vector3d& torque);
/// Energy of a joint's spring and stops [J].
double springEnergy(const Joint& joint, const JointPosition& position);
/// Its gradient in the joint's coordinates; of one axis: the first component.
Eigen::Vector3d springGradient(const Joint& joint, const JointPosition& position);

}  // namespace simgap
