/// \file
/// The frames of all bones of a rig, from a motion that turns every joint.
#pragma once

#include <string>
#include <vector>

#include "simgap/capture/joint_calibration.h"

namespace simgap {

/// A bone between the joint that moves it and one that it moves.
struct BoneLength {
  std::string from, to;  ///< joints
  double length = 0.0;   ///< [m] from the origin of its frame to the other joint's centre, or the point of its axis
};

struct RigCalibration {
  std::vector<FunctionalJoint> joints;  ///< shape (joints), as the rig lists them
  std::vector<BoneLength> bones;
  bool zero_pose = false;     ///< fixed by frames of the motion; otherwise by the target file
  TargetSet targets;          ///< markers in the frames of the bones
  std::vector<double> zeros;  ///< shape (joints): CaptureJoint::zero in these frames [m]
};

/// Bone frames of any tree of joints. A bone's origin is the joint that moves it: its centre, or the point of
/// its axis nearest to the origin of the bone before, or with a slide its target's; a root's is its first joint, of a
/// slide where the child's origin is at 0: in the frames of the zero pose, or as the rig has it (CaptureJoint::zero).
/// In the zero pose all bones point the same way, which is turned so that axes, and directions to joints
/// (CaptureJoint::along), are as the rig names them as far as all of them can be; each bone then turns about exactly
/// the axis named. \throws ConfigError: joints that are no tree. \throws DataError: see calibrateJoint; no frame in the
/// zero range.
RigCalibration calibrateRig(const Rig& rig, const TargetSet& targets, const std::vector<MotionFrame>& motion,
                            const JointCalibrationOptions& options);

}  // namespace simgap
