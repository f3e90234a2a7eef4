/// \file
/// Every hypothesis tried by one rollout of each motion with the cause in the model, and the quadratic of a fit
/// (motion_fit.h) for what the ordinary parameters would take over. Those of single muscles, by far the most, are tried
/// on some of the motions first.
#pragma once

#include <functional>
#include <span>
#include <vector>

#include "motion_fit.h"
#include "motion_hypotheses.h"

namespace simgap {

/// A hypothesis where the scan likes it best.
struct MotionTrial {
  std::size_t hypothesis = 0;
  EffectParameters start{};
  double gain = 0.0;  ///< promised [negative log posterior]
};

/// What a scan found.
struct MotionScan {
  std::vector<MotionTrial> trials;  ///< one per hypothesis that can be played, the best first
  /// As much as the best of all hypotheses would have promised with what it changes moved to other moments of each
  /// motion, shape (draws): what chance and structure without a name are good for.
  std::vector<double> placebos;
  long rollouts = 0;
};

/// \param points  a place each where the model without another cause stands; the first decides of placebos
/// \throws InterruptedError
MotionScan scanMotions(std::span<const MotionPoint> points, const std::vector<ArmHypothesis>& hypotheses,
                       std::uint64_t seed, const std::function<void(long rollouts)>& news);

}  // namespace simgap
