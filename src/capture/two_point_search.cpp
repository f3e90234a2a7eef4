#include "two_point_search.h"

#include <algorithm>
#include <array>
#include <cmath>

namespace simgap {
namespace {

constexpr double kClearSpread = 3.0;       // Blob::spread of a blob that others hardly disturb
constexpr double kAnchorTolerance = 1e-3;  // [m] of the two points' distance: four deviations, or this at most
constexpr double kAnchorSd = 0.05;         // [px] of a blob's centre, generous, as in MatchOptions
constexpr double kAnchorPlaceSd = 0.2e-3;  // [m] of a marker in the target file
constexpr double kThirdReach = 4e-3;       // [m] a ray that touches its sphere says little of the depth
constexpr int kFewestUntracked = 6;        // leave six freedoms: without a track five are too easily met by chance
constexpr double kAnotherPose = 3e-3;      // [m] a marker must move for the pose to be another one
constexpr double kGoodFit = 3.7;           // by that of all fits (0.1 % of good ones with 6 degrees of freedom)

struct CameraRay {
  Eigen::Vector3d origin, direction;  ///< in the left camera; direction of unit length
};

/// Where a ray meets a sphere, or comes nearest to one that it misses narrowly.
std::vector<Eigen::Vector3d> meet(const CameraRay& ray, const Eigen::Vector3d& centre, double radius) {
  const Eigen::Vector3d to = centre - ray.origin;
  const double along = to.dot(ray.direction);
  const double off = (to - along * ray.direction).norm();
  if (off > radius + kThirdReach) return {};
  const double half = std::sqrt(std::max(0.0, radius * radius - off * off));
  if (half < kThirdReach) return {ray.origin + along * ray.direction};
  return {ray.origin + (along - half) * ray.direction, ray.origin + (along + half) * ray.direction};
}

class TwoPointSearch {
 public:
  TwoPointSearch(const StereoCameras& cameras, const Triangulator& triangulator,
                 const std::vector<Eigen::Vector3d>& markers, const std::vector<PointCandidate>& points,
                 const FreeBlobs& left, const FreeBlobs& right, double variance)
      : cameras_(cameras),
        triangulator_(triangulator),
        markers_(markers),
        left_(left),
        right_(right),
        variance_(variance) {
    for (const PointCandidate& point : points) {
      if (left.used[point.left] || right.used[point.right]) continue;
      if (point.left_spread < kClearSpread && point.right_spread < kClearSpread) anchors_.push_back(&point);
    }
  }

  std::optional<TrackedTarget> run() {
    for (std::size_t i = 0; i < markers_.size(); ++i) {
      for (std::size_t j = 0; j < markers_.size(); ++j) {
        if (i != j) tryMarkers(i, j);
      }
    }
    const bool rivalled = rival_ && best_ && rival_->images == best_->images;
    return rivalled ? std::nullopt : best_;
  }

 private:
  /// All pairs of points that can be markers i and j, each with all blobs that can be a third one. Either image of i
  /// and j serves, so that half of the orders would do; but the sphere about the other point may be met more clearly.
  void tryMarkers(std::size_t i, std::size_t j) {
    for (const PointCandidate* a : anchors_) {
      for (const PointCandidate* b : anchors_) {
        if (a->left == b->left || a->right == b->right || !apart(*a, *b, (markers_[i] - markers_[j]).norm())) continue;
        for (std::size_t k = 0; k < markers_.size(); ++k) {
          if (k != i && k != j) tryThird({i, j, k}, *a, *b);
        }
      }
    }
  }

  bool apart(const PointCandidate& a, const PointCandidate& b, double wanted) const {
    const Eigen::Vector3d between = a.point - b.point;
    const double distance = between.norm();
    if (std::abs(distance - wanted) > kAnchorTolerance) return false;
    const Eigen::Vector3d along = between / distance;
    const double per_pixel =
        along.dot((triangulator_.covariancePerPixel(a) + triangulator_.covariancePerPixel(b)) * along);
    const double variance = kAnchorSd * kAnchorSd * per_pixel + 2.0 * kAnchorPlaceSd * kAnchorPlaceSd;
    return std::abs(distance - wanted) < 4.0 * std::sqrt(variance);
  }

  void tryThird(const std::array<std::size_t, 3>& of, const PointCandidate& a, const PointCandidate& b) {
    const double from_a = (markers_[of[2]] - markers_[of[0]]).norm();
    const double from_b = (markers_[of[2]] - markers_[of[1]]).norm();
    const auto tryBlob = [&](const CameraRay& ray, int l, int r) {
      if (best_ && explained(of, a, b, l, r)) return;
      for (const Eigen::Vector3d& third : meet(ray, a.point, from_a)) {
        if (std::abs((third - b.point).norm() - from_b) > kThirdReach) continue;
        const std::array<Eigen::Vector3d, 3> body{markers_[of[0]], markers_[of[1]], markers_[of[2]]};
        const std::array<Eigen::Vector3d, 3> camera{a.point, b.point, third};
        judge(fitTracked(cameras_, triangulator_, markers_, umeyama(body, camera), left_, right_));
      }
    };
    for (int l = 0; l < static_cast<int>(left_.blobs.size()); ++l) {
      if (left_.used[l] || l == a.left || l == b.left) continue;
      const PointCandidate seen = triangulator_.observe(l, -1, a.point, left_.blobs, right_.blobs);
      tryBlob({Eigen::Vector3d::Zero(), seen.left_image.homogeneous().normalized()}, l, -1);
    }
    const Eigen::Matrix3d back = cameras_.rotation.transpose();
    for (int r = 0; r < static_cast<int>(right_.blobs.size()); ++r) {
      if (right_.used[r] || r == a.right || r == b.right) continue;
      const PointCandidate seen = triangulator_.observe(-1, r, a.point, left_.blobs, right_.blobs);
      tryBlob({-back * cameras_.translation, back * seen.right_image.homogeneous().normalized()}, -1, r);
    }
  }

  /// Would lead to the best once more.
  bool explained(const std::array<std::size_t, 3>& of, const PointCandidate& a, const PointCandidate& b, int l,
                 int r) const {
    return best_->left[of[0]] == a.left && best_->right[of[0]] == a.right && best_->left[of[1]] == b.left &&
           best_->right[of[1]] == b.right && (l < 0 || best_->left[of[2]] == l) && (r < 0 || best_->right[of[2]] == r);
  }

  void judge(const std::optional<TrackedTarget>& found) {
    if (!found || found->images < kFewestUntracked) return;
    if (found->refined.square_sum > kGoodFit * variance_ * found->freedoms()) return;
    const auto elsewhere = [&](const TrackedTarget& other) {
      double farthest = 0.0;
      for (const Eigen::Vector3d& m : markers_) {
        farthest = std::max(farthest, (found->refined.pose * m - other.refined.pose * m).norm());
      }
      return farthest > kAnotherPose;
    };
    const auto better = [](const TrackedTarget& x, const TrackedTarget& y) {
      return x.images != y.images ? x.images > y.images : x.refined.square_sum < y.refined.square_sum;
    };
    if (!best_ || better(*found, *best_)) {
      if (best_ && elsewhere(*best_)) rival_ = best_;
      best_ = found;
    } else if (elsewhere(*best_) && (!rival_ || better(*found, *rival_))) {
      rival_ = found;
    }
  }

  const StereoCameras& cameras_;
  const Triangulator& triangulator_;
  const std::vector<Eigen::Vector3d>& markers_;
  const FreeBlobs &left_, &right_;
  double variance_;
  std::vector<const PointCandidate*> anchors_;
  std::optional<TrackedTarget> best_, rival_;
};

}  // namespace

std::optional<TrackedTarget> findByTwoPoints(const StereoCameras& cameras, const Triangulator& triangulator,
                                             const std::vector<Eigen::Vector3d>& markers,
                                             const std::vector<PointCandidate>& points, const FreeBlobs& left,
                                             const FreeBlobs& right, double variance) {
  return TwoPointSearch(cameras, triangulator, markers, points, left, right, variance).run();
}

}  // namespace simgap
