/// \file
/// Two calibrated cameras in the files of other programs.
#pragma once

#include <array>
#include <optional>
#include <span>
#include <string>

#include "simgap/capture/stereo_cameras.h"

namespace simgap {

struct CameraFile {
  std::string name;  ///< stands for the file in errors
  std::string text;
};

/// Two cameras; the file's keys say what it is.
/// - OpenCV FileStorage, YAML or XML: as readStereo.
/// - Kalibr's camchain (github.com/ethz-asl/kalibr/wiki/yaml-formats): cam0 is the left camera, cam1 the right one,
/// both
///   `pinhole` with `radtan` (k1 k2 p1 p2) or `none`; x_cam1 = T_cn_cnm1 x_cam0, metres.
/// - ROS's camera_info of camera_calibration_parsers, the left camera's file and the right one's: `plumb_bob` or
///   `rational_polynomial`. R and P of both say where the cameras stand: x_right = R2' (R1 x_left + [P2_14 / P2_11,
///   P2_24 / P2_22, 0]), metres.
/// \param files  one, or two of camera_info. \throws ConfigError: not one of these, another camera or lens model, a
/// number that is missing or absurd
StereoCameras readCameras(std::span<const CameraFile> files);

/// True for the file that writeStereo makes: FileStorage YAML.
bool isStereoYaml(const std::string& text);

/// Kalibr's camchain; empty for a lens that its models do not have: more than k1 k2 p1 p2.
std::optional<std::string> writeCamchain(const StereoCameras& cameras);
/// camera_info of the left camera and the right one, rectified as cv::stereoRectify does (zero disparity at infinity,
/// all pixels valid); empty for a lens that ROS has no name for: 12 or 14 coefficients. \param cameras  whose `size` is
/// known
std::optional<std::array<std::string, 2>> writeCameraInfo(const StereoCameras& cameras);
/// OpenCV FileStorage XML.
std::string writeStereoXml(const StereoCameras& cameras);

}  // namespace simgap
