/// \file
/// What separates a recorded pose from the equilibrium of the model.
#pragma once

#include "simgap/core/joint_kind.h"

namespace simgap {

struct PoseNoise {
  double capture_sd = 0.3 * kDegree;  ///< of a joint's measured position, per component [rad]
  bool joint_friction = true;         ///< false: S_p = S_capture
  double slide_sd = 1e-3;             ///< of a slide's measured position [m]

  double sdOf(JointType type) const { return kindOf(type).slides ? slide_sd : capture_sd; }
};

}  // namespace simgap
