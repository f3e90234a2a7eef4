#include "simgap/capture/target_matcher.h"

#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

constexpr int kFewestOfRotation = 3;  // fix a rotation
// Another place for the same target counts as a rival when it fits almost as well.
constexpr double kRivalRms = 0.1e-3;       // [m]
constexpr double kRivalDistance = 3.0e-3;  // [m] a marker must move for the place to be another one
constexpr double kLonelyTripleRms = 0.5;   // of max_rms: three markers that nothing predicted must fit better

Eigen::MatrixXd distancesOf(const std::vector<Eigen::Vector3d>& markers) {
  const auto n = static_cast<Eigen::Index>(markers.size());
  Eigen::MatrixXd distances(n, n);
  for (Eigen::Index i = 0; i < n; ++i) {
    for (Eigen::Index j = 0; j < n; ++j) {
      distances(i, j) = (markers[i] - markers[j]).norm();
    }
  }
  return distances;
}

bool better(const TargetMatch& a, const TargetMatch& b) {
  return a.visible != b.visible ? a.visible > b.visible : a.rms < b.rms;
}

}  // namespace

/// A depth-first search over the markers of one target.
struct TargetMatcher::Search {
  std::size_t target;
  std::vector<std::vector<int>> allowed;  ///< per marker: candidates to try
  std::vector<int> assigned;              ///< per marker: candidate, or -1
  int count = 0;
  std::optional<TargetMatch> best;
  std::optional<TargetMatch> rival;  ///< the best that puts the target elsewhere
};

TargetMatcher::TargetMatcher(const TargetSet& targets, const MatchOptions& options)
    : targets_(targets), options_(options) {
  for (const MarkerTarget& target : targets.targets) marker_distances_.push_back(distancesOf(target.markers));
}

void TargetMatcher::prepare(const Triangulator& triangulator, const std::vector<PointCandidate>& candidates) {
  candidates_ = &candidates;
  const std::size_t n = candidates.size();
  used_.assign(n, 0);
  distance_.resize(n * n);
  tolerance_.resize(n * n);
  std::vector<Eigen::Matrix3d> covariance;
  covariance.reserve(n);
  const double centroid_variance = options_.centroid_sd * options_.centroid_sd;
  for (const auto& c : candidates) covariance.push_back(centroid_variance * triangulator.covariancePerPixel(c));
  for (std::size_t a = 0; a < n; ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const Eigen::Vector3d between = candidates[a].point - candidates[b].point;
      const double distance = between.norm();
      const Eigen::Vector3d direction = between / std::max(distance, 1e-9);
      const double variance =
          direction.dot((covariance[a] + covariance[b]) * direction) + 2.0 * options_.marker_sd * options_.marker_sd;
      distance_[a * n + b] = distance_[b * n + a] = distance;
      tolerance_[a * n + b] = tolerance_[b * n + a] = options_.gate * std::sqrt(variance);
    }
  }
}

bool TargetMatcher::agrees(const Search& search, std::size_t marker, int candidate) const {
  const auto& candidates = *candidates_;
  const std::size_t n = candidates.size();
  const auto c = static_cast<std::size_t>(candidate);
  const Eigen::MatrixXd& wanted = marker_distances_[search.target];
  for (std::size_t other = 0; other < marker; ++other) {
    if (search.assigned[other] < 0) continue;
    const auto o = static_cast<std::size_t>(search.assigned[other]);
    if (candidates[o].left == candidates[c].left || candidates[o].right == candidates[c].right) return false;
    const double miss =
        distance_[o * n + c] - wanted(static_cast<Eigen::Index>(other), static_cast<Eigen::Index>(marker));
    if (std::abs(miss) > tolerance_[o * n + c]) return false;
  }
  return true;
}

void TargetMatcher::judge(Search& search) {
  const std::vector<Eigen::Vector3d>& markers = targets_.targets[search.target].markers;
  std::vector<Eigen::Vector3d> body, camera;
  for (std::size_t i = 0; i < markers.size(); ++i) {
    if (search.assigned[i] < 0) continue;
    body.push_back(markers[i]);
    camera.push_back((*candidates_)[search.assigned[i]].point);
  }
  TargetMatch match{search.assigned, search.count, umeyama(body, camera), 0.0};
  match.rms = fitRms(match.pose, body, camera);
  if (match.rms > options_.max_rms) return;
  const auto elsewhere = [&](const TargetMatch& other) {
    double farthest = 0.0;
    for (const auto& m : markers) farthest = std::max(farthest, (match.pose * m - other.pose * m).norm());
    return farthest > kRivalDistance;
  };
  if (!search.best || better(match, *search.best)) {
    if (search.best && elsewhere(*search.best)) search.rival = search.best;
    search.best = std::move(match);
  } else if (elsewhere(*search.best) && (!search.rival || better(match, *search.rival))) {
    search.rival = std::move(match);
  }
}

void TargetMatcher::assignMarker(Search& search, std::size_t marker) {
  const int left = static_cast<int>(search.assigned.size() - marker);
  const int wanted = search.best ? search.best->visible : kFewestOfRotation;
  if (search.count + left < wanted) return;
  if (left == 0) {
    judge(search);
    return;
  }
  for (const int candidate : search.allowed[marker]) {
    if (used_[candidate] || !agrees(search, marker, candidate)) continue;
    search.assigned[marker] = candidate;
    ++search.count;
    assignMarker(search, marker + 1);
    --search.count;
    search.assigned[marker] = -1;
  }
  assignMarker(search, marker + 1);  // the marker is hidden
}

std::optional<TargetMatch> TargetMatcher::find(std::size_t target, const TargetPose* near, MatchFailure& failure) {
  const std::vector<Eigen::Vector3d>& markers = targets_.targets[target].markers;
  Search search{target, {}, std::vector<int>(markers.size(), -1), 0, {}, {}};
  for (const Eigen::Vector3d& marker : markers) {
    std::vector<int>& allowed = search.allowed.emplace_back();
    for (std::size_t c = 0; c < candidates_->size(); ++c) {
      const double off = near == nullptr ? 0.0 : (*near * marker - (*candidates_)[c].point).norm();
      if (off < options_.track_gate) allowed.push_back(static_cast<int>(c));
    }
  }
  assignMarker(search, 0);
  failure = MatchFailure::kTooFewMarkers;
  if (!search.best) return std::nullopt;
  const bool lonely = near == nullptr && search.best->visible == kFewestOfRotation;
  if (lonely && search.best->rms > kLonelyTripleRms * options_.max_rms) return std::nullopt;
  failure = MatchFailure::kAmbiguous;
  const bool rivalled = search.rival && search.rival->visible == search.best->visible &&
                        search.rival->rms < 3.0 * search.best->rms + kRivalRms;
  if (rivalled && near == nullptr) return std::nullopt;
  failure = MatchFailure::kNone;
  return search.best;
}

void TargetMatcher::use(const TargetMatch& match) {
  for (const int c : match.candidate) {
    if (c < 0) continue;
    const PointCandidate& point = (*candidates_)[c];
    for (std::size_t o = 0; o < used_.size(); ++o) {
      const PointCandidate& other = (*candidates_)[o];
      if (other.left == point.left || other.right == point.right) used_[o] = 1;
    }
  }
}

const std::vector<std::optional<TargetMatch>>& TargetMatcher::match(
    const Triangulator& triangulator, const std::vector<PointCandidate>& candidates,
    const std::vector<std::optional<TargetPose>>& predicted) {
  prepare(triangulator, candidates);
  const std::size_t targets = targets_.targets.size();
  matches_.assign(targets, std::nullopt);
  failures_.assign(targets, MatchFailure::kTooFewMarkers);
  // A target seen whole where it was expected needs no search, and leaves less for the others to be confused with.
  for (std::size_t t = 0; t < targets; ++t) {
    if (!predicted[t]) continue;
    matches_[t] = find(t, &*predicted[t], failures_[t]);
    if (matches_[t] && static_cast<std::size_t>(matches_[t]->visible) < targets_.targets[t].markers.size()) {
      MatchFailure ignored{};
      const auto anywhere = find(t, nullptr, ignored);
      if (anywhere && anywhere->visible > matches_[t]->visible) matches_[t] = anywhere;
    }
    if (matches_[t]) use(*matches_[t]);
  }
  // The most complete of the others takes its blobs first.
  while (true) {
    std::optional<TargetMatch> best;
    std::size_t best_target = 0;
    for (std::size_t t = 0; t < targets; ++t) {
      if (matches_[t]) continue;
      auto found = find(t, nullptr, failures_[t]);
      if (found && (!best || better(*found, *best))) {
        best = std::move(found);
        best_target = t;
      }
    }
    if (!best) return matches_;
    use(*best);
    failures_[best_target] = MatchFailure::kNone;
    matches_[best_target] = std::move(best);
  }
}

}  // namespace simgap
