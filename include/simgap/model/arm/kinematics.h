/// \file
/// Where the bodies of an arm are, given the positions of its joints.
#pragma once

#include <span>
#include <vector>

#include "simgap/model/arm/arm.h"

namespace simgap {

/// Pose of a body: x_world = rotation * x_body + origin.
struct BodyInWorld {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d operator*(const Eigen::Vector3d& point_in_body) const { return rotation * point_in_body + origin; }
};

/// Rotation of a joint's child relative to its parent.
Eigen::Matrix3d childInParent(const Joint& joint, const JointPosition& position);
/// Where the point child_position of the child is in the parent's frame [m].
Eigen::Vector3d pivotInParent(const Joint& joint, const JointPosition& position);
/// Moves joints that follow others to where those are.
void coupleJoints(const ArmModel& model, std::span<JointPosition> joints);

/// Poses of all bodies. \param joints  shape (joints of the model), in its order.  \returns shape (bodies).
std::vector<BodyInWorld> bodiesInWorld(const ArmModel& model, std::span<const JointPosition> joints);

/// Where every pose starts (docs/simulation.md, "A pose"): spherical joints at identity, revolute joints at 0.3 rad,
/// prismatic ones at 0, or the nearest position their limits allow.
std::vector<JointPosition> startPosition(const ArmModel& model);

/// Straight distance of a muscle's attachments (000 eq. 6), whatever is between them. [m]
double muscleLength(const Muscle& muscle, std::span<const BodyInWorld> bodies);

}  // namespace simgap
