#include "tracked_target.h"

#include <algorithm>
#include <limits>
#include <span>

namespace simgap {
namespace {

// As parts of the focal length: how far a blob may be from where the track expects it, then from the images of the
// poses fitted to those.
constexpr double kReaches[] = {10.0 / 800.0, 3.0 / 800.0, 1.5 / 800.0};
constexpr int kFewestPairs = 2, kFewestImages = 5;

int nearestBlob(const FreeBlobs& free, const Eigen::Vector2d& pixel, double reach) {
  int nearest = -1;
  for (std::size_t b = 0; b < free.blobs.size(); ++b) {
    const double off = (free.blobs[b].centre - pixel).norm();
    if (free.used[b] || off >= reach) continue;
    reach = off;
    nearest = static_cast<int>(b);
  }
  return nearest;
}

/// The nearest blob of every marker; one that two markers claim is neither's.
std::vector<int> assign(const CameraIntrinsics& camera, const FreeBlobs& free,
                        const std::vector<Eigen::Vector3d>& in_camera, double reach) {
  std::vector<int> blobs;
  for (const Eigen::Vector3d& marker : in_camera) {
    blobs.push_back(marker.z() > 0.0 ? nearestBlob(free, projectPixel(camera, marker), reach * camera.focal()) : -1);
  }
  std::vector<int> result = blobs;
  for (int& blob : result) {
    if (std::count(blobs.begin(), blobs.end(), blob) > 1) blob = -1;
  }
  return result;
}

}  // namespace

std::optional<TrackedTarget> fitTracked(const StereoCameras& cameras, const Triangulator& triangulator,
                                        const std::vector<Eigen::Vector3d>& markers, const TargetPose& predicted,
                                        const FreeBlobs& left, const FreeBlobs& right) {
  TrackedTarget tracked;
  TargetPose pose = predicted;
  for (const double reach : kReaches) {
    std::vector<Eigen::Vector3d> in_left, in_right;
    for (const Eigen::Vector3d& marker : markers) {
      in_left.push_back(pose * marker);
      in_right.push_back(cameras.rotation * in_left.back() + cameras.translation);
    }
    tracked.left = assign(cameras.left, left, in_left, reach);
    tracked.right = assign(cameras.right, right, in_right, reach);
    tracked.marker.clear();
    tracked.seen.clear();
    tracked.images = 0;
    int pairs = 0;
    std::vector<Eigen::Vector3d> body;
    for (std::size_t i = 0; i < markers.size(); ++i) {
      const int l = tracked.left[i], r = tracked.right[i];
      if (l < 0 && r < 0) continue;
      pairs += l >= 0 && r >= 0;
      tracked.images += (l >= 0) + (r >= 0);
      tracked.marker.push_back(static_cast<int>(i));
      tracked.seen.push_back(triangulator.observe(l, r, in_left[i], left.blobs, right.blobs));
      body.push_back(markers[i]);
    }
    if (pairs < kFewestPairs || tracked.images < kFewestImages) return std::nullopt;
    std::vector<const PointCandidate*> seen;
    for (const PointCandidate& candidate : tracked.seen) seen.push_back(&candidate);
    tracked.refined = refinePose(cameras, pose, body, seen);
    pose = tracked.refined.pose;
  }
  return tracked;
}

}  // namespace simgap
