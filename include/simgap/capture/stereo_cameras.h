/// \file
/// Two calibrated cameras, as OpenCV writes them.
#pragma once

#include <Eigen/Geometry>
#include <opencv2/core.hpp>
#include <string>
#include <vector>

namespace simgap {

/// A pinhole camera with OpenCV's distortion model.
struct CameraIntrinsics {
  cv::Matx33d K = cv::Matx33d::eye();
  std::vector<double> distortion;                             ///< k1, k2, p1, p2, [k3, [k4, k5, k6, …]]; empty: none
  double focal() const { return 0.5 * (K(0, 0) + K(1, 1)); }  ///< [px]
};

/// x_right = rotation x_left + translation, metres; the left camera's frame (z forward) is the world of a capture.
struct StereoCameras {
  cv::Size size;  ///< of the images [px]; empty when the file does not say
  CameraIntrinsics left;
  CameraIntrinsics right;
  Eigen::Matrix3d rotation = Eigen::Matrix3d::Identity();
  Eigen::Vector3d translation = Eigen::Vector3d::Zero();

  double baseline() const { return translation.norm(); }
  /// E with x_right' E x_left = 0 for a point's normalized images.
  Eigen::Matrix3d essential() const;
};

/// Reads OpenCV FileStorage YAML: K1 D1 K2 D2 R T, or M1/M2 or cameraMatrix1/distCoeffs1 as other programs name them;
/// image_width and image_height when they are there.
/// \throws ConfigError that names the file and the key.
StereoCameras readStereo(const std::string& text, const std::string& file);
/// The file, with `comments` (one a line) at its head.
std::string writeStereo(const StereoCameras& cameras, const std::vector<std::string>& comments = {});

/// Normalized, undistorted images of pixels, iterated to 1e-12 (OpenCV's default stops after 5 rounds, 1e-3 px off at
/// the corners of a wide lens). `normalized` is resized.
void undistort(const CameraIntrinsics& camera, const std::vector<cv::Point2d>& pixels,
               std::vector<cv::Point2d>& normalized);
/// Pixel of a point in the camera's frame.
Eigen::Vector2d projectPixel(const CameraIntrinsics& camera, const Eigen::Vector3d& point);

}  // namespace simgap
