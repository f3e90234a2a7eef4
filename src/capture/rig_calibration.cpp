#include "simgap/capture/rig_calibration.h"

#include <algorithm>
#include <cmath>

#include <fmt/format.h>

#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

/// A direction as a target's frame has it and as the bone's frame shall have it, unit length.
struct Direction {
  Eigen::Vector3d measured, named;
};

/// The rotation that brings the measured directions nearest to the named ones (Wahba's problem); the smallest one where
/// they leave a turn open.
Eigen::Matrix3d align(const std::vector<Direction>& directions) {
  constexpr double kParallel = 0.1;  // sine
  if (directions.empty()) return Eigen::Matrix3d::Identity();
  const Direction& first = directions.front();
  const bool open = std::ranges::all_of(
      directions, [&](const Direction& d) { return d.measured.cross(first.measured).norm() < kParallel; });
  if (open) return rotationBetween(first.measured, first.named).toRotationMatrix();
  std::vector<Eigen::Vector3d> from, to;  // points about the origin, which stays
  for (const Direction& d : directions) {
    for (const double sign : {1.0, -1.0}) {
      from.emplace_back(sign * d.measured);
      to.emplace_back(sign * d.named);
    }
  }
  return umeyama(from, to).rotation;
}

class RigFrames {
 public:
  RigFrames(const Rig& rig, const TargetSet& targets, const std::vector<MotionFrame>& motion,
            const JointCalibrationOptions& options)
      : rig_(rig), targets_(targets), motion_(motion), options_(options) {}

  RigCalibration find() {
    sortFromRoots();
    result_.zero_pose = options_.zero_first >= 0;
    for (const CaptureJoint& joint : rig_.joints) result_.joints.push_back(calibrateJoint(joint, motion_, options_));
    if (result_.zero_pose) zeroSlides();
    placeOrigins();
    turnBones();
    measureZeros();
    result_.targets = targets_;
    for (std::size_t t = 0; t < targets_.targets.size(); ++t) {
      if (joint_of_[t] < 0 && !isParent(static_cast<int>(t))) continue;
      for (Eigen::Vector3d& marker : result_.targets.targets[t].markers) marker = bone_[t] * (marker - origin_[t]);
    }
    return std::move(result_);
  }

 private:
  bool isParent(int target) const {
    return std::ranges::find(rig_.joints, target, &CaptureJoint::parent) != rig_.joints.end();
  }

  /// Joints in an order in which each stands after the one that moves its parent.
  void sortFromRoots() {
    joint_of_.assign(targets_.targets.size(), -1);
    for (std::size_t j = 0; j < rig_.joints.size(); ++j) {
      int& of = joint_of_[rig_.joints[j].child];
      if (of >= 0) {
        throw ConfigError(fmt::format("joints {} and {} of the rig move the same target, expected a tree",
                                      rig_.joints[of].name, rig_.joints[j].name));
      }
      of = static_cast<int>(j);
    }
    std::vector<bool> sorted(rig_.joints.size(), false);
    while (order_.size() < rig_.joints.size()) {
      const std::size_t before = order_.size();
      for (std::size_t j = 0; j < rig_.joints.size(); ++j) {
        const int above = joint_of_[rig_.joints[j].parent];
        if (sorted[j] || (above >= 0 && !sorted[above])) continue;
        sorted[j] = true;
        order_.push_back(j);
      }
      if (order_.size() == before) throw ConfigError("the joints of the rig close a loop, expected a tree");
    }
  }

  bool slides(std::size_t j) const { return kindOf(rig_.joints[j].type).slides; }

  void zeroSlides() {
    for (std::size_t j = 0; j < rig_.joints.size(); ++j) {
      if (!slides(j)) continue;
      FunctionalJoint& found = result_.joints[j];
      const std::vector<TargetPose> poses = zeroPoses(rig_.joints[j]);
      double along = 0.0;
      for (const TargetPose& pose : poses) {
        along += (pose.origin - found.in_parent).dot(found.axis_in_parent) / static_cast<double>(poses.size());
      }
      found.in_parent += along * found.axis_in_parent;
    }
  }

  void measureZeros() {
    for (std::size_t j = 0; j < rig_.joints.size(); ++j) {
      const CaptureJoint& joint = rig_.joints[j];
      const FunctionalJoint& found = result_.joints[j];
      result_.zeros.push_back(
          slides(j) ? joint.axis.dot(bone_[joint.parent] * (found.in_parent - origin_[joint.parent])) : 0.0);
    }
  }

  /// The origins of the bones in their targets' frames, and the senses of the axes.
  void placeOrigins() {
    origin_.assign(targets_.targets.size(), Eigen::Vector3d::Zero());
    std::vector<bool> placed(targets_.targets.size(), false);
    for (const std::size_t j : order_) {
      const CaptureJoint& joint = rig_.joints[j];
      FunctionalJoint& found = result_.joints[j];
      const Eigen::Vector3d& parent_origin = origin_[joint.parent];
      if (kindOf(joint.type).has_axis && !slides(j)) {
        if (found.axis_in_parent.dot(joint.axis) < 0.0) {  // SARA knows the axis but not its sense
          found.axis_in_parent *= -1.0;
          found.axis_in_child *= -1.0;
        }
        const double along = (parent_origin - found.in_parent).dot(found.axis_in_parent);
        found.in_parent += along * found.axis_in_parent;
        found.in_child += along * found.axis_in_child;
      }
      if (joint_of_[joint.parent] < 0 && !placed[joint.parent]) origin_[joint.parent] = found.in_parent;
      placed[joint.parent] = true;
      origin_[joint.child] = found.in_child;
      if (const int above = joint_of_[joint.parent]; above >= 0) {
        result_.bones.push_back({rig_.joints[above].name, joint.name, (found.in_parent - parent_origin).norm()});
      }
    }
  }

  std::vector<TargetPose> zeroPoses(const CaptureJoint& joint) const {
    std::vector<MotionFrame> still;
    for (const MotionFrame& frame : motion_) {
      if (frame.frame >= options_.zero_first && frame.frame <= options_.zero_last) still.push_back(frame);
    }
    std::vector<TargetPose> poses = relativePoses(joint, still);
    if (poses.empty()) {
      throw DataError(fmt::format("no frame from {} to {} shows both targets of joint {}: the zero pose is unknown",
                                  options_.zero_first, options_.zero_last, joint.name));
    }
    return poses;
  }
  /// How the child's target is turned in the parent's in the zero pose; as the target file has them without one.
  Eigen::Matrix3d zeroRotation(const CaptureJoint& joint) const {
    return meanRotation(zeroPoses(joint)).toRotationMatrix();
  }

  /// What the joints that a bone carries say of its frame.
  std::vector<Direction> directionsOf(int target) const {
    std::vector<Direction> directions;
    for (const std::size_t j : order_) {
      const CaptureJoint& joint = rig_.joints[j];
      if (joint.parent != target) continue;
      const FunctionalJoint& found = result_.joints[j];
      const bool axis = kindOf(joint.type).has_axis;
      if (axis) directions.push_back({found.axis_in_parent, joint.axis});
      if (!joint.along || slides(j)) continue;
      Eigen::Vector3d named = *joint.along;
      if (axis) named -= named.dot(joint.axis) * joint.axis;  // the origin is the axis' nearest point
      const Eigen::Vector3d way = found.in_parent - origin_[target];
      if (way.norm() > 0.0 && named.norm() > 1e-3) directions.push_back({way.normalized(), named.normalized()});
    }
    return directions;
  }

  void turnBones() {
    const std::size_t n = targets_.targets.size();
    bone_.assign(n, Eigen::Matrix3d::Identity());
    if (result_.zero_pose) {
      turnTogether();
    } else {
      for (std::size_t t = 0; t < n; ++t) bone_[t] = align(directionsOf(static_cast<int>(t)));
    }
    for (const std::size_t j : order_) {  // each turns about exactly the axis that the rig names
      const CaptureJoint& joint = rig_.joints[j];
      if (!kindOf(joint.type).has_axis) continue;
      if (slides(j)) {  // never turns
        bone_[joint.child] = bone_[joint.parent] * meanRotation(relativePoses(joint, motion_)).toRotationMatrix();
        continue;
      }
      const Eigen::Vector3d axis = bone_[joint.child] * result_.joints[j].axis_in_child;
      bone_[joint.child] = rotationBetween(axis.normalized(), joint.axis).toRotationMatrix() * bone_[joint.child];
    }
  }

  /// In the zero pose all bones of a tree point the same way: what their joints say is put together in its root.
  void turnTogether() {
    const std::size_t n = targets_.targets.size();
    std::vector<Eigen::Matrix3d> in_root(n, Eigen::Matrix3d::Identity());
    std::vector<int> root(n);
    for (std::size_t t = 0; t < n; ++t) root[t] = static_cast<int>(t);
    for (const std::size_t j : order_) {
      const CaptureJoint& joint = rig_.joints[j];
      root[joint.child] = root[joint.parent];
      in_root[joint.child] = in_root[joint.parent] * zeroRotation(joint);
    }
    std::vector<std::vector<Direction>> directions(n);
    for (std::size_t t = 0; t < n; ++t) {
      for (const Direction& d : directionsOf(static_cast<int>(t))) {
        directions[root[t]].push_back({in_root[t] * d.measured, d.named});
      }
    }
    for (std::size_t t = 0; t < n; ++t) bone_[t] = align(directions[root[t]]) * in_root[t];
  }

  const Rig& rig_;
  const TargetSet& targets_;
  const std::vector<MotionFrame>& motion_;
  const JointCalibrationOptions& options_;
  std::vector<int> joint_of_;            ///< by target: the joint that moves it; -1: a root
  std::vector<std::size_t> order_;       ///< of joints, from the roots
  std::vector<Eigen::Vector3d> origin_;  ///< of the bones [m], in their targets' frames
  std::vector<Eigen::Matrix3d> bone_;    ///< the bone's frame from its target's
  RigCalibration result_;
};

}  // namespace

RigCalibration calibrateRig(const Rig& rig, const TargetSet& targets, const std::vector<MotionFrame>& motion,
                            const JointCalibrationOptions& options) {
  if (rig.joints.empty()) throw ConfigError("found no joint in the rig, expected at least one to calibrate");
  return RigFrames(rig, targets, motion, options).find();
}

}  // namespace simgap
