/// \file
/// A target of which both cameras see two markers alone, and one camera others, where no track says where it is.
#pragma once

#include <optional>
#include <vector>

#include "tracked_target.h"

namespace simgap {

/// Two points fix a target but for a turn about the line through them. A third marker in one image fixes that: its ray
/// meets the sphere about the first point on which the marker must be, at most twice. Every such pose is fitted to all
/// images near to it (fitTracked); the one that explains most of them is the answer.
/// \param points    of both cameras' blobs; only those whose blobs are free and stand clear of others are tried.
/// \param variance  of a free blob's centre, which the residuals of a good fit have [px^2]
/// \returns none when fewer than six images agree, or as many agree with another pose.
std::optional<TrackedTarget> findByTwoPoints(const StereoCameras& cameras, const Triangulator& triangulator,
                                             const std::vector<Eigen::Vector3d>& markers,
                                             const std::vector<PointCandidate>& points, const FreeBlobs& left,
                                             const FreeBlobs& right, double variance);

}  // namespace simgap
