/// \file
/// Can these targets be told apart? Looked at before a marker is glued.
#pragma once

#include <string>
#include <vector>

#include "simgap/capture/marker_targets.h"

namespace simgap {

/// The closest that `count` markers of one target come to `count` markers of another (or of itself, in another order).
struct Likeness {
  int from = 0, to = 0;        ///< target indices
  std::vector<int> markers;    ///< of `from`
  std::vector<int> taken_for;  ///< of `to`
  bool mirrored = false;
  double rms = 0.0;  ///< [m] of the rigid fit: what noise must bridge to confuse them
};

/// What is known of one target.
struct TargetReport {
  std::string name;
  double smallest_gap = 0.0;  ///< [m] between two of its distances: below the noise a pair of markers is ambiguous
  double flatness = 0.0;      ///< [m] root mean square distance of the markers from their plane
  Likeness symmetry;          ///< all its markers in another order
  Likeness mirror;            ///< all its markers against its mirror image, in any order
  Likeness triple;            ///< three of its markers taken for three others: what occlusion leaves
};

struct TargetSetReport {
  std::vector<TargetReport> targets;
  std::vector<Likeness> cross;         ///< all pairs of targets, as many markers as the smaller has
  std::vector<Likeness> cross_triple;  ///< all pairs of targets, three markers
  double noise = 0.0;                  ///< [m]
  /// A likeness within kMargin standard deviations of the noise is a confusion.
  bool confused(const Likeness& likeness) const { return likeness.rms < kMargin * noise; }
  bool sound() const;  ///< no confusion of whole targets
  static constexpr double kMargin = 4.0;
};

/// \param noise  [m] standard deviation of a triangulated marker.
TargetSetReport checkTargets(const TargetSet& targets, double noise);

/// The best fit of any `count` markers of `a` to any of `b`; with `self` not to themselves. Exhaustive, by branch and
/// bound: a pair's distance that differs by d costs at least d / sqrt(2 count).
Likeness closestLikeness(const std::vector<Eigen::Vector3d>& a, const std::vector<Eigen::Vector3d>& b,
                         std::size_t count, bool self, bool mirrored);

}  // namespace simgap
