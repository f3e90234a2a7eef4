/// \file
/// Which point is which marker of which target: the largest subset of markers whose pairwise distances agree with those
/// of the points (001 section IV: a graph that knows the targets in advance).
#pragma once

#include <optional>
#include <vector>

#include "simgap/capture/marker_targets.h"
#include "simgap/capture/rigid_fit.h"

namespace simgap {

struct MatchOptions {
  double centroid_sd = 0.05;  ///< [px] of a blob's centre, for the tolerance of distances; generous
  double marker_sd = 0.2e-3;  ///< [m] of a marker in the target file, per axis
  double gate = 4.0;          ///< standard deviations
  double max_rms = 0.6e-3;    ///< [m] of a fit
  double track_gate = 0.03;   ///< [m] a marker may be off its predicted place
};

/// The markers of a target that were found.
struct TargetMatch {
  std::vector<int> candidate;  ///< shape (markers): index of the point, -1 when not found
  int visible = 0;
  TargetPose pose;   ///< by Umeyama
  double rms = 0.0;  ///< [m]
};

/// Why a target was not found.
enum class MatchFailure { kNone, kTooFewMarkers, kAmbiguous };

class TargetMatcher {
 public:
  TargetMatcher(const TargetSet& targets, const MatchOptions& options = {});

  /// \param predicted  shape (targets): where a target is expected; its markers are then looked for near there first.
  /// \returns shape (targets); no blob is used twice.
  const std::vector<std::optional<TargetMatch>>& match(const Triangulator& triangulator,
                                                       const std::vector<PointCandidate>& candidates,
                                                       const std::vector<std::optional<TargetPose>>& predicted);
  const std::vector<MatchFailure>& failures() const { return failures_; }

 private:
  struct Search;
  void prepare(const Triangulator& triangulator, const std::vector<PointCandidate>& candidates);
  std::optional<TargetMatch> find(std::size_t target, const TargetPose* near, MatchFailure& failure);
  void assignMarker(Search& search, std::size_t marker);
  void judge(Search& search);
  bool agrees(const Search& search, std::size_t marker, int candidate) const;
  void use(const TargetMatch& match);

  const TargetSet& targets_;
  MatchOptions options_;
  std::vector<Eigen::MatrixXd> marker_distances_;  ///< per target
  const std::vector<PointCandidate>* candidates_ = nullptr;
  std::vector<double> distance_, tolerance_;  ///< shape (candidates, candidates)
  std::vector<char> used_;                    ///< shape (candidates)
  std::vector<std::optional<TargetMatch>> matches_;
  std::vector<MatchFailure> failures_;
};

}  // namespace simgap
