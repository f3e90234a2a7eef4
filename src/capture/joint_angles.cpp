#include "simgap/capture/joint_angles.h"

#include <cmath>
#include <numbers>

#include "simgap/core/joint_kind.h"

namespace simgap {

AxisAngle twistAbout(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& axis) {
  const double along = rotation.vec().dot(axis);
  double angle = 2.0 * std::atan2(along, rotation.w());
  if (angle > std::numbers::pi) angle -= 2.0 * std::numbers::pi;
  if (angle <= -std::numbers::pi) angle += 2.0 * std::numbers::pi;
  const double across = (rotation.vec() - along * axis).norm();
  return {angle, 2.0 * std::atan2(across, std::hypot(rotation.w(), along))};
}

namespace {

/// The way a = axis . R_p' (o_c - o_p) of a slide and its variance: moved by the origins of both targets, and by
/// turning the parent's, which turns the axis.
JointPosition wayOf(const CaptureJoint& joint, const TargetFrame& parent, const TargetFrame& child, double& variance) {
  using Vector6 = Eigen::Matrix<double, 6, 1>;
  const Eigen::Vector3d axis = parent.pose.rotation * joint.axis;
  const Eigen::Vector3d way = child.pose.origin - parent.pose.origin;
  Vector6 by_parent, by_child;
  by_parent << axis.cross(way), -axis;
  by_child << Eigen::Vector3d::Zero(), axis;
  variance = by_parent.dot(parent.covariance * by_parent) + by_child.dot(child.covariance * by_child);
  JointPosition position;
  position.angle = axis.dot(way) - joint.zero;
  return position;
}

}  // namespace

std::optional<JointSample> jointAngles(const Rig& rig, std::span<const TargetFrame> targets, std::size_t frame,
                                       double time) {
  JointSample sample{frame, time, {}, {}, {}};
  for (const CaptureJoint& joint : rig.joints) {
    const TargetFrame& parent = targets[joint.parent];
    const TargetFrame& child = targets[joint.child];
    if (!parent.found || !child.found) return std::nullopt;
    JointPosition position;
    position.rotation = Eigen::Quaterniond(parent.pose.rotation.transpose() * child.pose.rotation).normalized();
    if (position.rotation.w() < 0.0) position.rotation.coeffs() = -position.rotation.coeffs();
    const Eigen::Matrix3d in_camera = (parent.covariance + child.covariance).topLeftCorner<3, 3>();
    const Eigen::Matrix3d covariance = parent.pose.rotation.transpose() * in_camera * parent.pose.rotation;
    double off_axis = 0.0;
    double variance = covariance.trace();
    if (kindOf(joint.type).slides) {
      off_axis = 2.0 * std::atan2(position.rotation.vec().norm(), position.rotation.w());
      position = wayOf(joint, parent, child, variance);
    } else if (kindOf(joint.type).has_axis) {
      const AxisAngle twist = twistAbout(position.rotation, joint.axis);
      position.angle = twist.angle;
      off_axis = twist.off_axis;
      variance = joint.axis.dot(covariance * joint.axis);
    }
    sample.joints.push_back(position);
    sample.sd.push_back(std::sqrt(variance));
    sample.off_axis.push_back(off_axis);
  }
  return sample;
}

}  // namespace simgap
