/// \file
/// Where the joints are between the targets: markers sit on the skin of a robot, not on its bones.
/// Direction of a slide: the principal one of the child's ways. Centre of a spherical joint: SCoRE, and axis of a
/// revolute one: SARA; R. M. Ehrig, W. R. Taylor, G. N. Duda, M. O. Heller, J. Biomechanics 39 (2006) and 40 (2007).
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
  double max_centre_sd = 2e-3;  ///< [m] refuse a centre that is known worse
  double min_range = 0.175;     ///< [rad] refuse a rotation whose second axis (revolute: only axis) spans less;
                                ///< of a slide as JointKind::counted: 35 mm
  long zero_first = -1, zero_last = -1;  ///< frames in which the robot is in its zero pose; -1: none
};

/// A joint as both of its targets see it.
struct FunctionalJoint {
  std::string name;
  JointType type{};
  std::size_t frames = 0;
  Eigen::Vector3d in_parent = Eigen::Vector3d::Zero();  ///< centre, or a point of the axis, or where the child's origin
                                                        ///< is with the slide at 0 [m], target's frame
  Eigen::Vector3d in_child = Eigen::Vector3d::Zero();
  Eigen::Vector3d axis_in_parent = Eigen::Vector3d::Zero();  ///< revolute, prismatic: unit vector
  Eigen::Vector3d axis_in_child = Eigen::Vector3d::Zero();
  double residual = 0.0;   ///< [m] root mean square distance of the two images of the centre; prismatic: from the axis
  double centre_sd = 0.0;  ///< [m] largest standard deviation of the centre; else across the axis
  double axis_sd = 0.0;    ///< [rad] of one that has an axis
  double condition = 0.0;  ///< smallest singular value by that of a joint that turned everywhere (0-1); prismatic: the
                           ///< part of the ways that is along the axis
  double range = 0.0;  ///< [rad] 4 standard deviations of the rotation about the weakest axis that counts; prismatic:
                       ///< of the way [m]
};

/// \throws DataError: fewer than 10 frames with both targets, a range of motion or a centre_sd outside the options.
FunctionalJoint calibrateJoint(const CaptureJoint& joint, const std::vector<MotionFrame>& motion,
                               const JointCalibrationOptions& options);

/// Child in parent, one per frame in which both were seen.
std::vector<TargetPose> relativePoses(const CaptureJoint& joint, const std::vector<MotionFrame>& motion);
Eigen::Quaterniond meanRotation(const std::vector<TargetPose>& poses);

}  // namespace simgap
