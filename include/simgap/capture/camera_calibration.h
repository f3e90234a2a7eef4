/// \file
/// Stereo cameras from views of a board (Zhang 2000, as OpenCV's stereoCalibrate), judged on views it did not see.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "simgap/capture/board.h"
#include "simgap/capture/stereo_cameras.h"

namespace simgap {

struct CameraCalibrationOptions {
  int distortion = 5;          ///< coefficients: 4 (k1 k2 p1 p2), 5 (and k3) or 8 (rational)
  double outlier_ratio = 3.0;  ///< a view with so many times the median error is left out
  std::size_t folds = 10;      ///< groups of views held out in turn
  std::size_t fewest_views = 6;
  int threads = 0;  ///< 0: all
};

/// A number of the calibration with its standard deviation (delete-a-group jackknife over the folds).
struct CalibratedNumber {
  std::string name;
  std::string unit;
  double value = 0.0;
  double sd = 0.0;
};

struct CameraCalibration {
  StereoCameras cameras;
  double rms = 0.0;          ///< [px] per point, of the views used
  double heldout_rms = 0.0;  ///< [px] per point, of views that were held out (only the board's pose is fitted to them)
  std::vector<double> view_rms;       ///< shape (views) [px]; NaN when left out
  std::vector<std::size_t> outliers;  ///< views left out
  std::vector<CalibratedNumber> numbers;
  double left_coverage = 0.0, right_coverage = 0.0;  ///< part of an 8x6 grid over the image that holds a corner (0-1)
};

/// \throws DataError: too few views. \throws NumericsError: OpenCV cannot calibrate.
CameraCalibration calibrateCameras(const std::vector<BoardView>& views, cv::Size size,
                                   const CameraCalibrationOptions& options);

/// Root mean square reprojection error of a view in both images [px per point] with the board where it fits best.
double viewError(const StereoCameras& cameras, const BoardView& view);

/// Corners of all views in both images, left beside right (BGR): where nothing is drawn the lens is not known.
cv::Mat drawCoverage(const std::vector<BoardView>& views, cv::Size size);

/// Distance of two bright spheres in one pair; empty unless both images show exactly two. [m]
std::optional<double> measureScaleBar(const StereoCameras& cameras, const cv::Mat& left, const cv::Mat& right,
                                      double marker_radius);

}  // namespace simgap
