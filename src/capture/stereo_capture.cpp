#include "simgap/capture/stereo_capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"

namespace simgap {
namespace {

// Before the first fits: what a centre is worth, and how many residuals that guess weighs.
constexpr double kGuessedCentroidSd = 0.02;  // [px]
constexpr double kGuessFreedoms = 6.0;
// A marker is dropped when its four residuals are this much larger than the others say (an F statistic); a limb that
// hides part of a marker moves its centre by tenths of a pixel.
constexpr double kOutlierRatio = 15.0;
// A fit whose variance is this much larger than that of all fits (0.1 % of good ones with 6 degrees of freedom).
constexpr double kSpoiltRatio = 3.7;
constexpr int kFewestMarkers = 3;

struct SeenMarkers {
  std::vector<int> marker;
  std::vector<Eigen::Vector3d> body;
  std::vector<Eigen::Vector3d> camera;
  std::vector<const PointCandidate*> seen;
};

SeenMarkers seenMarkers(const MarkerTarget& target, const std::vector<int>& candidate,
                        const std::vector<PointCandidate>& points) {
  SeenMarkers markers;
  for (std::size_t i = 0; i < candidate.size(); ++i) {
    if (candidate[i] < 0) continue;
    const PointCandidate& point = points[candidate[i]];
    markers.marker.push_back(static_cast<int>(i));
    markers.body.push_back(target.markers[i]);
    markers.camera.push_back(point.point);
    markers.seen.push_back(&point);
  }
  return markers;
}

double freedomsOf(int visible) { return 4.0 * visible - 6.0; }

}  // namespace

StereoCapture::StereoCapture(const StereoCameras& cameras, const TargetSet& targets, const CaptureOptions& options)
    : cameras_(cameras),
      targets_(targets),
      options_(options),
      left_blobs_(options.blobs),
      right_blobs_(options.blobs),
      triangulator_(cameras, targets.marker_radius, options.epipolar_gate),
      matcher_(targets_, options.match),
      history_(targets.targets.size()),
      predicted_(targets.targets.size()),
      square_sum_(kGuessFreedoms * kGuessedCentroidSd * kGuessedCentroidSd),
      freedoms_(kGuessFreedoms) {}

double StereoCapture::centroidSd() const { return std::sqrt(square_sum_ / freedoms_); }

void StereoCapture::forget() {
  for (auto& poses : history_) poses = {};
}

void StereoCapture::predict() {
  for (std::size_t t = 0; t < history_.size(); ++t) {
    const auto& [last, before] = history_[t];
    predicted_[t] = last;
    if (last && before) {
      predicted_[t]->rotation = last->rotation * before->rotation.transpose() * last->rotation;
      predicted_[t]->origin = 2.0 * last->origin - before->origin;
    }
  }
}

void StereoCapture::fit(std::size_t target, TargetMatch match) {
  const MarkerTarget& definition = targets_.targets[target];
  TargetFrame& frame = frame_.targets[target];
  SeenMarkers markers = seenMarkers(definition, match.candidate, frame_.points);
  RefinedPose refined = refinePose(cameras_, match.pose, markers.body, markers.seen);
  while (match.visible > kFewestMarkers) {
    const auto worst = std::max_element(refined.marker_px.begin(), refined.marker_px.end());
    std::vector<int> fewer = match.candidate;
    fewer[markers.marker[static_cast<std::size_t>(worst - refined.marker_px.begin())]] = -1;
    const SeenMarkers rest = seenMarkers(definition, fewer, frame_.points);
    const RefinedPose without = refinePose(cameras_, refined.pose, rest.body, rest.seen);
    const double variance = std::max(without.square_sum / freedomsOf(match.visible - 1), square_sum_ / freedoms_);
    if ((refined.square_sum - without.square_sum) / 4.0 < kOutlierRatio * variance) break;
    match.candidate = fewer;
    --match.visible;
    markers = rest;
    refined = without;
  }
  // What a ghost or a limb has spoilt must not widen the deviations of all other frames, but widens its own.
  const double freedoms = freedomsOf(match.visible);
  const double own = refined.square_sum / freedoms;
  const double pooled = square_sum_ / freedoms_;
  square_sum_ += freedoms * std::min(own, kSpoiltRatio * pooled);
  freedoms_ += freedoms;
  frame.found = true;
  frame.candidate = match.candidate;
  frame.visible = match.visible;
  frame.pose = refined.pose;
  frame.rms = fitRms(refined.pose, markers.body, markers.camera);
  for (const PointCandidate* seen : markers.seen) frame.epipolar += seen->epipolar / match.visible;
  frame.covariance = (own > kSpoiltRatio * pooled ? own : square_sum_ / freedoms_) * refined.cofactor;
}

const FramePair& StereoCapture::process(const cv::Mat& left, const cv::Mat& right) {
  const auto expectSize = [&](const cv::Mat& image, const char* side) {
    if (cameras_.size.empty() || image.size() == cameras_.size) return;
    throw DataError(fmt::format("{} image: found {}x{} px, expected {}x{} as the stereo calibration says", side,
                                image.cols, image.rows, cameras_.size.width, cameras_.size.height));
  };
  expectSize(left, "left");
  expectSize(right, "right");
  frame_.left = left_blobs_.detect(left);
  frame_.right = right_blobs_.detect(right);
  frame_.rejections = {left_blobs_.rejections(), right_blobs_.rejections()};
  frame_.points = triangulator_.candidates(frame_.left, frame_.right);
  predict();
  const auto& matches = matcher_.match(triangulator_, frame_.points, predicted_);
  frame_.targets.assign(targets_.targets.size(), {});
  int used = 0;
  for (std::size_t t = 0; t < matches.size(); ++t) {
    frame_.targets[t].failure = matcher_.failures()[t];
    frame_.targets[t].candidate.assign(targets_.targets[t].markers.size(), -1);
    if (matches[t]) fit(t, *matches[t]);
    used += frame_.targets[t].visible;
    history_[t][1] = history_[t][0];
    history_[t][0].reset();
    if (frame_.targets[t].found) history_[t][0] = frame_.targets[t].pose;
  }
  frame_.ghosts = static_cast<int>(frame_.left.size() + frame_.right.size()) - 2 * used;
  return frame_;
}

}  // namespace simgap
