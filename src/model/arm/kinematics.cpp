#include "simgap/model/arm/kinematics.h"

#include <algorithm>

#include "simgap/core/joint_kind.h"

namespace simgap {

namespace {

Eigen::Matrix3d turnedBy(const Joint& joint, const JointPosition& position) {
  return kindOf(joint.type).rotation(joint.axis, position);
}

}  // namespace

Eigen::Matrix3d childInParent(const Joint& joint, const JointPosition& position) {
  if (joint.parent_orientation.w() == 1.0 && joint.child_orientation.w() == 1.0) return turnedBy(joint, position);
  return joint.parent_orientation * turnedBy(joint, position) * joint.child_orientation.conjugate();
}

Eigen::Vector3d pivotInParent(const Joint& joint, const JointPosition& position) {
  if (!joint.slides()) return joint.parent_position;
  return joint.parent_position + joint.parent_orientation * (position.angle * joint.axis);
}

std::vector<BodyInWorld> bodiesInWorld(const ArmModel& model, std::span<const JointPosition> joints) {
  std::vector<BodyInWorld> bodies(model.bodies.size());
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    const BodyInWorld& parent = bodies[joint.parent];
    BodyInWorld& child = bodies[joint.child];
    child.rotation = parent.rotation * childInParent(joint, joints[j]);
    child.origin = parent * pivotInParent(joint, joints[j]) - child.rotation * joint.child_position;
  }
  return bodies;
}

std::vector<JointPosition> startPosition(const ArmModel& model) {
  constexpr double kStartAngle = 0.3;  // [rad]
  std::vector<JointPosition> start(model.joints.size());
  for (std::size_t j = 0; j < start.size(); ++j) {
    const Joint& joint = model.joints[j];
    start[j].angle = std::clamp(joint.slides() ? 0.0 : kStartAngle, joint.lower_limit, joint.upper_limit);
  }
  coupleJoints(model, start);
  return start;
}

void coupleJoints(const ArmModel& model, std::span<JointPosition> joints) {
  for (std::size_t j = 0; j < joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    if (joint.follows()) joints[j].angle = joint.coupling_offset + joint.coupling_ratio * joints[joint.leader].angle;
  }
}

double muscleLength(const Muscle& muscle, std::span<const BodyInWorld> bodies) {
  const auto& [from, to] = muscle.attachments;
  return (bodies[to.body] * to.point - bodies[from.body] * from.point).norm();
}

}  // namespace simgap
