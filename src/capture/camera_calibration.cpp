#include "simgap/capture/camera_calibration.h"

#include <fmt/format.h>
#include <tbb/parallel_for.h>
#include <tbb/task_arena.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <opencv2/calib3d.hpp>
#include <opencv2/imgproc.hpp>

#include "simgap/capture/rigid_fit.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/rotation.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr int kOutlierRounds = 5;
constexpr double kFewestKept = 0.7;  // of the views: more outliers than that are no outliers
constexpr int kCoverageColumns = 8;
constexpr int kCoverageRows = 6;

using Views = std::vector<const BoardView*>;

/// What OpenCV's functions take and give.
struct OpenCvCalibration {
  cv::Mat k1, d1, k2, d2, r, t;
  double rms = 0.0;
  std::vector<double> view_rms;
};

struct OpenCvPoints {
  std::vector<std::vector<cv::Point3f>> board;
  std::vector<std::vector<cv::Point2f>> left, right;
  explicit OpenCvPoints(const Views& views) {
    for (const BoardView* view : views) {
      board.push_back(view->board);
      left.push_back(view->left);
      right.push_back(view->right);
    }
  }
};

/// To ten digits of the largest number: what the last steps leave behind them depends on where in memory OpenCV's
/// LAPACK finds the numbers, which differs from run to run.
void roundOff(cv::Mat& matrix) {
  const double largest = cv::norm(matrix, cv::NORM_INF);
  if (largest == 0.0) return;
  const double unit = std::pow(10.0, std::floor(std::log10(largest)) - 9.0);
  for (double& value : cv::Mat_<double>(matrix)) value = unit * std::round(value / unit);
}

int flagsFor(int distortion) {
  if (distortion == 8) return cv::CALIB_RATIONAL_MODEL;
  return distortion == 4 ? cv::CALIB_FIX_K3 : 0;
}

/// \param start  of an earlier calibration; without one each camera is calibrated alone first.
OpenCvCalibration calibrate(const Views& views, cv::Size size, int distortion, const OpenCvCalibration* start) {
  stopIfInterrupted();  // OpenCV cannot be: each of its calibrations goes to its end
  const OpenCvPoints points(views);
  const int flags = flagsFor(distortion);
  OpenCvCalibration c;
  try {
    if (start != nullptr) {
      c = {start->k1.clone(), start->d1.clone(), start->k2.clone(), start->d2.clone(), {}, {}, 0.0, {}};
    } else {
      cv::calibrateCamera(points.board, points.left, size, c.k1, c.d1, cv::noArray(), cv::noArray(), flags);
      cv::calibrateCamera(points.board, points.right, size, c.k2, c.d2, cv::noArray(), cv::noArray(), flags);
    }
    cv::Mat essential, fundamental, errors;
    // Of the length of all numbers, focal lengths in pixels among them: 1e-9 of it is the tenth digit of a distortion.
    const cv::TermCriteria until(cv::TermCriteria::COUNT | cv::TermCriteria::EPS, 100, 1e-14);
    c.rms = cv::stereoCalibrate(points.board, points.left, points.right, c.k1, c.d1, c.k2, c.d2, size, c.r, c.t,
                                essential, fundamental, errors, flags | cv::CALIB_USE_INTRINSIC_GUESS, until);
    cv::Mat turn;  // a vector: whatever it is rounded to, it is one of a rotation
    cv::Rodrigues(c.r, turn);
    for (cv::Mat* matrix : {&c.k1, &c.d1, &c.k2, &c.d2, &turn, &c.t}) roundOff(*matrix);
    cv::Rodrigues(turn, c.r);
    for (int v = 0; v < errors.rows; ++v) {
      c.view_rms.push_back(std::hypot(errors.at<double>(v, 0), errors.at<double>(v, 1)) / std::sqrt(2.0));
    }
  } catch (const cv::Exception& error) {
    throw NumericsError(fmt::format("the cameras cannot be calibrated from {} views: {}", views.size(), error.err));
  }
  if (!std::isfinite(c.rms)) throw NumericsError("the calibration of the cameras did not converge");
  return c;
}

StereoCameras camerasOf(const OpenCvCalibration& c, cv::Size size, int distortion) {
  StereoCameras cameras;
  cameras.size = size;
  const auto camera = [&](const cv::Mat& k, const cv::Mat& d) {
    CameraIntrinsics result;
    result.K = k;
    result.distortion.assign(d.begin<double>(), d.begin<double>() + distortion);
    return result;
  };
  cameras.left = camera(c.k1, c.d1);
  cameras.right = camera(c.k2, c.d2);
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) cameras.rotation(i, j) = c.r.at<double>(i, j);
    cameras.translation[i] = c.t.at<double>(i);
  }
  return cameras;
}

std::vector<CalibratedNumber> numbersOf(const StereoCameras& cameras) {
  static constexpr std::array<const char*, 8> kDistortion = {"k1", "k2", "p1", "p2", "k3", "k4", "k5", "k6"};
  std::vector<CalibratedNumber> numbers;
  for (const auto& [side, camera] : {std::pair{"left ", &cameras.left}, std::pair{"right ", &cameras.right}}) {
    numbers.push_back({std::string(side) + "fx", "px", camera->K(0, 0), 0.0});
    numbers.push_back({std::string(side) + "fy", "px", camera->K(1, 1), 0.0});
    numbers.push_back({std::string(side) + "cx", "px", camera->K(0, 2), 0.0});
    numbers.push_back({std::string(side) + "cy", "px", camera->K(1, 2), 0.0});
    for (std::size_t i = 0; i < camera->distortion.size(); ++i) {
      numbers.push_back({std::string(side) + kDistortion[i], "", camera->distortion[i], 0.0});
    }
  }
  const Eigen::Vector3d turn = logSo3(Eigen::Quaterniond(cameras.rotation));
  for (int i = 0; i < 3; ++i) {
    numbers.push_back({fmt::format("rotation {}", "xyz"[i]), "deg", toDegrees(turn[i]), 0.0});
  }
  for (int i = 0; i < 3; ++i) {
    numbers.push_back({fmt::format("translation {}", "xyz"[i]), "mm", 1e3 * cameras.translation[i], 0.0});
  }
  numbers.push_back({"baseline", "mm", 1e3 * cameras.baseline(), 0.0});
  return numbers;
}

double coverage(const std::vector<BoardView>& views, cv::Size size, bool left) {
  std::vector<char> hit(kCoverageColumns * kCoverageRows, 0);
  for (const BoardView& view : views) {
    for (const cv::Point2f& p : left ? view.left : view.right) {
      const int x = std::clamp(static_cast<int>(p.x * kCoverageColumns / static_cast<float>(size.width)), 0,
                               kCoverageColumns - 1);
      const int y =
          std::clamp(static_cast<int>(p.y * kCoverageRows / static_cast<float>(size.height)), 0, kCoverageRows - 1);
      hit[y * kCoverageColumns + x] = 1;
    }
  }
  return static_cast<double>(std::count(hit.begin(), hit.end(), 1)) / static_cast<double>(hit.size());
}

/// Holds out one group of views after the other: the error on what was held out, and the jackknife's deviations.
void crossValidate(const Views& views, cv::Size size, const CameraCalibrationOptions& options,
                   const OpenCvCalibration& full, CameraCalibration& result) {
  const std::size_t folds = std::min(options.folds, views.size());
  std::vector<std::vector<CalibratedNumber>> numbers(folds);
  std::vector<double> squares(folds), points(folds);
  tbb::task_arena arena(options.threads > 0 ? options.threads : tbb::task_arena::automatic);
  arena.execute([&] {
    tbb::parallel_for(std::size_t{0}, folds, [&](std::size_t fold) {
      Views seen, held_out;
      for (std::size_t v = 0; v < views.size(); ++v) (v % folds == fold ? held_out : seen).push_back(views[v]);
      const StereoCameras cameras =
          camerasOf(calibrate(seen, size, options.distortion, &full), size, options.distortion);
      numbers[fold] = numbersOf(cameras);
      for (const BoardView* view : held_out) {
        const auto n = static_cast<double>(2 * view->board.size());
        squares[fold] += n * std::pow(viewError(cameras, *view), 2);
        points[fold] += n;
      }
    });
  });
  double square_sum = 0.0;
  double point_sum = 0.0;
  for (std::size_t f = 0; f < folds; ++f) {
    square_sum += squares[f];
    point_sum += points[f];
  }
  result.heldout_rms = std::sqrt(square_sum / point_sum);
  const auto g = static_cast<double>(folds);
  for (std::size_t i = 0; i < result.numbers.size(); ++i) {
    double mean = 0.0;
    for (const auto& fold : numbers) mean += fold[i].value / g;
    double spread = 0.0;
    for (const auto& fold : numbers) spread += std::pow(fold[i].value - mean, 2);
    result.numbers[i].sd = std::sqrt((g - 1.0) / g * spread);
  }
}

}  // namespace

double viewError(const StereoCameras& cameras, const BoardView& view) {
  std::vector<cv::Point2d> left, right;
  undistort(cameras.left, {view.left.begin(), view.left.end()}, left);
  undistort(cameras.right, {view.right.begin(), view.right.end()}, right);
  cv::Mat turn, shift, rotation;
  cv::solvePnP(view.board, left, cv::Matx33d::eye(), cv::noArray(), turn, shift);
  cv::Rodrigues(turn, rotation);
  TargetPose start;
  for (int i = 0; i < 3; ++i) {
    for (int j = 0; j < 3; ++j) start.rotation(i, j) = rotation.at<double>(i, j);
    start.origin[i] = shift.at<double>(i);
  }
  std::vector<Eigen::Vector3d> body;
  std::vector<PointCandidate> seen(view.board.size());
  std::vector<const PointCandidate*> pointers;
  for (std::size_t i = 0; i < view.board.size(); ++i) {
    body.emplace_back(view.board[i].x, view.board[i].y, view.board[i].z);
    seen[i].left_image = {left[i].x, left[i].y};
    seen[i].right_image = {right[i].x, right[i].y};
    pointers.push_back(&seen[i]);
  }
  const RefinedPose refined = refinePose(cameras, start, body, pointers);
  return std::sqrt(refined.square_sum / static_cast<double>(2 * body.size()));
}

CameraCalibration calibrateCameras(const std::vector<BoardView>& views, cv::Size size,
                                   const CameraCalibrationOptions& options) {
  if (views.size() < options.fewest_views) {
    throw DataError(
        fmt::format("the board was seen by both cameras in {} views, expected at least {}: is --board right?",
                    views.size(), options.fewest_views));
  }
  std::vector<std::size_t> kept(views.size());
  for (std::size_t v = 0; v < views.size(); ++v) kept[v] = v;
  const auto chosen = [&] {
    Views some;
    for (const std::size_t v : kept) some.push_back(&views[v]);
    return some;
  };
  OpenCvCalibration full = calibrate(chosen(), size, options.distortion, nullptr);
  for (int round = 0; round < kOutlierRounds; ++round) {
    const double limit = options.outlier_ratio * upperMedian(full.view_rms);
    std::vector<std::size_t> good;
    for (std::size_t i = 0; i < kept.size(); ++i) {
      if (full.view_rms[i] <= limit) good.push_back(kept[i]);
    }
    const bool too_few = static_cast<double>(good.size()) < kFewestKept * static_cast<double>(views.size()) ||
                         good.size() < options.fewest_views;
    if (good.size() == kept.size() || too_few) break;
    kept = good;
    full = calibrate(chosen(), size, options.distortion, nullptr);
  }
  CameraCalibration result;
  result.cameras = camerasOf(full, size, options.distortion);
  result.rms = full.rms;
  result.view_rms.assign(views.size(), std::numeric_limits<double>::quiet_NaN());
  for (std::size_t i = 0; i < kept.size(); ++i) result.view_rms[kept[i]] = full.view_rms[i];
  for (std::size_t v = 0; v < views.size(); ++v) {
    if (std::isnan(result.view_rms[v])) result.outliers.push_back(v);
  }
  result.numbers = numbersOf(result.cameras);
  result.left_coverage = coverage(views, size, true);
  result.right_coverage = coverage(views, size, false);
  crossValidate(chosen(), size, options, full, result);
  return result;
}

cv::Mat drawCoverage(const std::vector<BoardView>& views, cv::Size size) {
  cv::Mat canvas(size.height, 2 * size.width, CV_8UC3, cv::Scalar(24, 24, 24));
  for (int side = 0; side < 2; ++side) {
    const int offset = side * size.width;
    for (int c = 0; c <= kCoverageColumns; ++c) {
      const int x = offset + std::min(size.width - 1, c * size.width / kCoverageColumns);
      cv::line(canvas, {x, 0}, {x, size.height - 1}, cv::Scalar(70, 70, 70));
    }
    for (int r = 0; r <= kCoverageRows; ++r) {
      const int y = std::min(size.height - 1, r * size.height / kCoverageRows);
      cv::line(canvas, {offset, y}, {offset + size.width - 1, y}, cv::Scalar(70, 70, 70));
    }
    for (const BoardView& view : views) {
      for (const cv::Point2f& p : side == 0 ? view.left : view.right) {
        cv::circle(canvas, {offset + cvRound(p.x), cvRound(p.y)}, 2, cv::Scalar(0, 159, 230), cv::FILLED, cv::LINE_AA);
      }
    }
  }
  return canvas;
}

std::optional<double> measureScaleBar(const StereoCameras& cameras, const cv::Mat& left, const cv::Mat& right,
                                      double marker_radius) {
  BlobDetector left_detector, right_detector;
  const std::vector<Blob>& left_blobs = left_detector.detect(left);
  const std::vector<Blob>& right_blobs = right_detector.detect(right);
  if (left_blobs.size() != 2 || right_blobs.size() != 2) return std::nullopt;
  Triangulator triangulator(cameras, marker_radius, 1e6);
  std::vector<const PointCandidate*> pairs(4, nullptr);
  for (const PointCandidate& c : triangulator.candidates(left_blobs, right_blobs)) {
    pairs[2 * c.left + c.right] = &c;
  }
  // Either straight or crossed; the epipolar lines tell.
  const auto misfit = [&](std::size_t a, std::size_t b) {
    return pairs[a] && pairs[b] ? std::hypot(pairs[a]->epipolar, pairs[b]->epipolar)
                                : std::numeric_limits<double>::infinity();
  };
  const bool straight = misfit(0, 3) <= misfit(1, 2);
  if (!std::isfinite(straight ? misfit(0, 3) : misfit(1, 2))) return std::nullopt;
  return straight ? (pairs[0]->point - pairs[3]->point).norm() : (pairs[1]->point - pairs[2]->point).norm();
}

}  // namespace simgap
