/// \file
/// A pair of images to the poses of all targets.
#pragma once

#include <array>
#include <optional>
#include <vector>

#include "simgap/capture/target_matcher.h"

namespace simgap {

struct CaptureOptions {
  BlobOptions blobs;
  MatchOptions match;
  double epipolar_gate = 1.5;  ///< [px]
};

/// One target in one frame.
struct TargetFrame {
  bool found = false;
  MatchFailure failure = MatchFailure::kNone;
  std::vector<int> candidate;  ///< shape (markers): index into FramePair::points, -1 when not seen
  int visible = 0;             ///< markers used that both cameras see
  int single = 0;              ///< further ones that one camera sees; 0 where those of both were enough
  TargetPose pose;             ///< in the left camera
  double rms = 0.0;            ///< [m] of the markers' distances after the fit
  double epipolar = 0.0;       ///< [px] mean of the markers' signed epipolar errors
  Eigen::Matrix<double, 6, 6> covariance = Eigen::Matrix<double, 6, 6>::Zero();  ///< rotation [rad], origin [m]
};

/// All that one pair of images gave.
struct FramePair {
  std::vector<Blob> left, right;
  std::array<BlobRejections, 2> rejections;
  std::vector<PointCandidate> points;
  std::vector<TargetFrame> targets;  ///< shape (targets)
  int ghosts = 0;                    ///< blobs of both images that no target used
};

struct TrackedTarget;

/// Frames one after the other: a target is looked for where it was heading first.
class StereoCapture {
 public:
  StereoCapture(const StereoCameras& cameras, const TargetSet& targets, const CaptureOptions& options = {});
  StereoCapture(const StereoCapture&) = delete;
  StereoCapture& operator=(const StereoCapture&) = delete;

  /// \param left, right  8-bit grey of the cameras' size.  \returns valid until the next call.
  const FramePair& process(const cv::Mat& left, const cv::Mat& right);
  /// Forgets where the targets were.
  void forget();
  /// Standard deviation of a blob's centre, from the residuals of all fits so far [px]. The covariances follow it.
  double centroidSd() const;

 private:
  void fit(std::size_t target, TargetMatch match);
  /// Of a target that was not matched: by two markers, what one camera sees of the others, and its track, or a search
  /// where there is none.
  void follow(std::size_t target);
  bool accept(std::size_t target, const TrackedTarget& tracked);
  void remember(std::size_t target);
  void predict();
  /// Of a marker's image in both cameras, where the targets are expected; 0: nowhere. [px]
  std::array<double, 2> expectedRadii() const;

  const StereoCameras cameras_;
  const TargetSet targets_;
  CaptureOptions options_;
  BlobDetector left_blobs_, right_blobs_;
  Triangulator triangulator_;
  TargetMatcher matcher_;
  FramePair frame_;
  /// Where a target was last, in the frame before that, and how many frames ago it was lost.
  struct Track {
    std::optional<TargetPose> last, before;
    int lost = 0;
  };
  std::vector<Track> tracks_;
  std::vector<std::optional<TargetPose>> predicted_;
  double square_sum_;  ///< [px^2] of the residuals of all fits
  double freedoms_;
};

}  // namespace simgap
