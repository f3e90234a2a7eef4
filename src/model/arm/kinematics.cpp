#include "simgap/model/arm/kinematics.h"

namespace simgap {

Eigen::Matrix3d childInParent(const Joint& joint, const JointPosition& position) {
  if (joint.type == JointType::kSpherical) return position.rotation.toRotationMatrix();
  return Eigen::AngleAxisd(position.angle, joint.axis).toRotationMatrix();
}

std::vector<BodyInWorld> bodiesInWorld(const ArmModel& model, std::span<const JointPosition> joints) {
  std::vector<BodyInWorld> bodies(model.bodies.size());
  for (std::size_t j = 0; j < model.joints.size(); ++j) {
    const Joint& joint = model.joints[j];
    const BodyInWorld& parent = bodies[joint.parent];
    BodyInWorld& child = bodies[joint.child];
    child.rotation = parent.rotation * childInParent(joint, joints[j]);
    child.origin = parent * joint.parent_position - child.rotation * joint.child_position;
  }
  return bodies;
}

std::vector<JointPosition> startPosition(const ArmModel& model) {
  constexpr double kStartAngle = 0.3;  // [rad]
  std::vector<JointPosition> start(model.joints.size());
  for (std::size_t j = 0; j < start.size(); ++j) {
    start[j].angle = std::clamp(kStartAngle, model.joints[j].lower_limit, model.joints[j].upper_limit);
  }
  return start;
}

double muscleLength(const Muscle& muscle, std::span<const BodyInWorld> bodies) {
  const auto& [from, to] = muscle.attachments;
  return (bodies[to.body] * to.point - bodies[from.body] * from.point).norm();
}

}  // namespace simgap
