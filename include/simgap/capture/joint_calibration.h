/// \file
/// Where the joints are between the targets: markers sit on the skin of a robot, not on its bones.
/// Centre of a spherical joint: SCoRE, and axis of a revolute one: SARA; R. M. Ehrig, W. R. Taylor, G. N. Duda,
/// M. O. Heller, J. Biomechanics 39 (2006) and 40 (2007).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/capture/marker_targets.h"
#include "simgap/capture/rigid_fit.h"
#include "simgap/core/csv.h"

namespace simgap {

/// Poses of all targets in one frame (in the camera); empty where a target was not seen.
struct MotionFrame {
  long frame = 0;
  std::vector<std::optional<TargetPose>> targets;
};
/// frames.csv of a capture. \throws DataError: an unknown target, and all that CsvTable refuses.
std::vector<MotionFrame> readMotion(const CsvTable& table, const TargetSet& targets);

struct JointCalibrationOptions {
  double max_centre_sd = 2e-3;           ///< [m] refuse a centre that is known worse
  double min_range = 0.175;              ///< [rad] refuse a rotation whose second axis (revolute: only axis) spans less
  long zero_first = -1, zero_last = -1;  ///< frames in which the arm is in its zero pose; -1: none
};

/// A joint as both of its targets see it.
struct FunctionalJoint {
  std::string name;
  JointType type = JointType::kSpherical;
  std::size_t frames = 0;
  Eigen::Vector3d in_parent = Eigen::Vector3d::Zero();  ///< centre, or a point of the axis [m], target's frame
  Eigen::Vector3d in_child = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_in_parent = Eigen::Vector3d::Zero();  ///< revolute: unit vector
  Eigen::Vector3d axis_in_child = Eigen::Vector3d::Zero();
  double residual = 0.0;   ///< [m] root mean square distance of the two images of the centre
  double centre_sd = 0.0;  ///< [m] largest standard deviation of the centre; revolute: across the axis
  double axis_sd = 0.0;    ///< [rad] revolute
  double condition = 0.0;  ///< smallest singular value by that of a joint that turned everywhere (0-1)
  double range = 0.0;      ///< [rad] 4 standard deviations of the rotation about the weakest axis that counts
};

/// \throws DataError: fewer than 10 frames with both targets, a range of motion or a centre_sd outside the options.
FunctionalJoint calibrateJoint(const CaptureJoint& joint, const std::vector<MotionFrame>& motion,
                               const JointCalibrationOptions& options);

struct ArmJointCalibration {
  FunctionalJoint shoulder, elbow;
  double upper_arm = 0.0;  ///< [m] shoulder centre to elbow axis
  bool zero_pose = false;  ///< fixed by frames of the motion; otherwise by the target file
  TargetSet targets;       ///< markers in the frames of the bones
};

/// Joints and bone frames of the paper's arm: a spherical joint followed by a revolute one. Bones: the origin of torso
/// and humerus is the shoulder centre, the humerus hangs from it along -z with the elbow's axis as the rig names it;
/// the forearm's origin is the elbow. \throws ConfigError: another arrangement of joints. \throws DataError: see
/// calibrateJoint; no frame in the zero range.
ArmJointCalibration calibrateArmJoints(const Rig& rig, const TargetSet& targets, const std::vector<MotionFrame>& motion,
                                       const JointCalibrationOptions& options);

}  // namespace simgap
