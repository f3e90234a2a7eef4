/// \file
/// Positions of the joints from the frames of their targets (001 section IV: q_s from F_o, F_h; q_e from F_h, F_f).
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "simgap/capture/marker_targets.h"
#include "simgap/capture/stereo_capture.h"

namespace simgap {

/// All joints at one moment.
struct JointSample {
  std::size_t frame = 0;  ///< number of the image pair
  double time = 0.0;      ///< [s]
  std::vector<JointPosition> joints;
  std::vector<double> sd;  ///< shape (joints) [rad]: root mean square angle of the error; revolute: of the angle; of a
                           ///< slide of its way [m]
  std::vector<double> off_axis;  ///< shape (joints) [rad]: rotation a hinge or slide cannot make; 0 for spherical ones
};

/// Rotation as an angle about `axis`, in (-pi, pi], and the angle of what is left (swing). [rad]
struct AxisAngle {
  double angle;
  double off_axis;
};
AxisAngle twistAbout(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& axis);

/// Empty unless the targets of all joints were found.
std::optional<JointSample> jointAngles(const Rig& rig, std::span<const TargetFrame> targets, std::size_t frame,
                                       double time);

}  // namespace simgap
