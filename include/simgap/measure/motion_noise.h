/// \file
/// The white noise of recorded motions, from the recordings themselves.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "simgap/measure/motion_set.h"

namespace simgap {

/// Standard deviations per channel group.
struct MotionNoise {
  std::vector<double> joints;  ///< shape (joints) [rad], of a slide [m], per component
  double shafts = 0.0;         ///< [rad]
  double currents = 0.0;       ///< [A]
};

/// What is known of it otherwise.
struct KnownNoise {
  std::optional<double> joints, shafts;  ///< [rad]
  std::optional<double> slides;          ///< [m]
  std::optional<double> currents;        ///< [A]
};

/// From the channels' fourth differences, in which no motion of an arm is left; medians, so that steps and outliers do
/// not count. Never below what a good encoder or shunt leaves.
MotionNoise estimateNoise(std::span<const RecordedMotion> motions, const PoseLayout& layout,
                          const KnownNoise& known = {});

}  // namespace simgap
