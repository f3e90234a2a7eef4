/// \file
/// Where a target is: the rigid motion that brings its markers onto what was seen.
#pragma once

#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "simgap/capture/triangulation.h"

namespace simgap {

/// Pose of a target: x_camera = rotation x_body + origin.
struct TargetPose {
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< [m]
  Eigen::Vector3d operator*(const Eigen::Vector3d& body) const { return rotation * body + origin; }
};

/// Least squares between points, without scale and without mirroring: S. Umeyama, "Least-squares estimation of
/// transformation parameters between two point patterns", PAMI 13(4), 1991. At least 3 points.
TargetPose umeyama(std::span<const Eigen::Vector3d> body, std::span<const Eigen::Vector3d> camera);

/// Root mean square distance of the points after the motion [m].
double fitRms(const TargetPose& pose, std::span<const Eigen::Vector3d> body, std::span<const Eigen::Vector3d> camera);

/// A pose refined to the smallest reprojection error in both images.
struct RefinedPose {
  TargetPose pose;
  double square_sum = 0.0;               ///< of the 4n residuals [px^2]
  std::vector<double> marker_px;         ///< shape (n): root mean square of each marker's four residuals [px]
  Eigen::Matrix<double, 6, 6> cofactor;  ///< covariance per px^2: rotation (about the camera's axes) [rad],
                                         ///< then position of the body's origin [m]
};

/// Gauss-Newton over exp(w) R and origin from `start`. Residuals are the undistorted images times the focal length.
/// \param seen  the candidates of the markers `body`, shape (n)
RefinedPose refinePose(const StereoCameras& cameras, const TargetPose& start, std::span<const Eigen::Vector3d> body,
                       std::span<const PointCandidate* const> seen);

}  // namespace simgap
