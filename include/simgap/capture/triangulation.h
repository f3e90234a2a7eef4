/// \file
/// Blobs of two images to points in space.
#pragma once

#include <Eigen/Core>
#include <array>
#include <vector>

#include "simgap/capture/blobs.h"
#include "simgap/capture/stereo_cameras.h"

namespace simgap {

/// A left and a right blob that may be the same marker.
struct PointCandidate {
  int left = 0;                                          ///< blob index
  int right = 0;                                         ///< blob index
  Eigen::Vector2d left_image = Eigen::Vector2d::Zero();  ///< normalized, undistorted, corrected for the sphere
  Eigen::Vector2d right_image = Eigen::Vector2d::Zero();
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< in the left camera [m]
  double left_spread = 1.0;                         ///< Blob::spread
  double right_spread = 1.0;
  double epipolar = 0.0;  ///< [px] signed: by how much the right image misses its epipolar line
};

/// Moves two normalized images to the nearest pair on epipolar lines: P. Lindstrom, "Triangulation made easy", CVPR
/// 2010, algorithm niter2; E as in StereoCameras::essential().
void correctToEpipolar(const Eigen::Matrix3d& essential, Eigen::Vector2d& left, Eigen::Vector2d& right);

/// All pairs within the epipolar gate that lie in front of both cameras.
class Triangulator {
 public:
  /// \param gate  [px] largest |epipolar|.  \param marker_radius  [m]
  Triangulator(const StereoCameras& cameras, double marker_radius, double gate);

  /// Every pair within the gate is kept; which is right is for the targets to say. An ellipse's centre is not the image
  /// of its sphere's centre: normalized images are scaled by 1 - (radius / depth)^2.
  const std::vector<PointCandidate>& candidates(const std::vector<Blob>& left, const std::vector<Blob>& right);

  /// A marker expected at `expected` (in the left camera), as the blobs `left` and `right` show it; -1: not seen by
  /// that camera, whose spread is then infinite. `point` is the expected one.
  PointCandidate observe(int left, int right, const Eigen::Vector3d& expected, const std::vector<Blob>& left_blobs,
                         const std::vector<Blob>& right_blobs) const;

  /// Covariance of a triangulated point per variance of a free blob's centre in px^2. [m^2 / px^2]
  Eigen::Matrix3d covariancePerPixel(const PointCandidate& candidate) const;

 private:
  void pair(int left, int right, const std::array<double, 2>& spread, double signed_error);

  const StereoCameras cameras_;
  Eigen::Matrix3d essential_;
  double radius_;
  double gate_;
  std::vector<cv::Point2d> pixels_, left_, right_;
  std::vector<PointCandidate> candidates_;
};

}  // namespace simgap
