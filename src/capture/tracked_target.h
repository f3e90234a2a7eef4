/// \file
/// A target of which too few markers are seen by both cameras, where its track says it should be.
#pragma once

#include <optional>
#include <vector>

#include "simgap/capture/rigid_fit.h"
#include "simgap/capture/triangulation.h"

namespace simgap {

/// Blobs of both images that no other target uses.
struct FreeBlobs {
  const std::vector<Blob>& blobs;
  std::vector<char> used;
};

struct TrackedTarget {
  std::vector<int> left, right;      ///< shape (markers): blob, or -1
  std::vector<int> marker;           ///< of each observation below
  std::vector<PointCandidate> seen;  ///< what the pose was fitted to; a camera that does not see it has infinite spread
  RefinedPose refined;
  int images = 0;                                         ///< of markers, in both cameras together
  double freedoms() const { return 2.0 * images - 6.0; }  ///< of the fit: two numbers an image, six of the pose
};

/// Two markers seen by both cameras leave one angle open; a third seen by one of them closes it. Blobs are assigned to
/// the predicted images where only one is near, then anew to the images of the pose fitted to these.
/// \returns none unless two markers are seen by both cameras and another by one.
std::optional<TrackedTarget> fitTracked(const StereoCameras& cameras, const Triangulator& triangulator,
                                        const std::vector<Eigen::Vector3d>& markers, const TargetPose& predicted,
                                        const FreeBlobs& left, const FreeBlobs& right);

}  // namespace simgap
