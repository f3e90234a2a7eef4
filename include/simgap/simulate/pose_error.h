/// \file
/// How far simulated poses are from measured ones (001 eq. 3, 4 and 7).
#pragma once

#include <span>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/measure/pose_set.h"
#include "simgap/simulate/pose_protocol.h"

namespace simgap {

/// What of a spherical joint is squared in 001 eq. 3: the angle between the rotations, or, as printed there
/// (arccos Q . Q'), half of it, which counts the joint a quarter.
enum class PoseObjective { kGeodesic, kPaper };
std::string_view toString(PoseObjective objective);

/// A model judged on a pose set.
struct Assessment {
  std::vector<PoseOutcome> outcomes;        ///< shape (poses)
  std::vector<std::vector<double>> errors;  ///< shape (poses, joints), >= 0; empty row where the pose is invalid
                                            ///< [rad], of a slide [m]
  std::vector<double> mje;                  ///< mean joint error over the valid poses, shape (joints); NaN: none
  std::size_t valid = 0;                    ///< poses that came to rest
  /// Sum of squared errors (001 eq. 3) [rad^2], ways of slides as JointKind::counted; NaN when a pose is invalid.
  double fitness = 0.0;
};

Assessment assess(const PoseLayout& layout, std::span<const Pose> poses, std::span<const PoseOutcome> outcomes,
                  PoseObjective objective = PoseObjective::kGeodesic);

/// "acquisition error of biceps, 12.3 deg": why a pose is invalid.
std::string describe(const PoseOutcome& outcome, const PoseLayout& layout);

}  // namespace simgap
