#include "simgap/capture/stereo_capture.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "tracked_target.h"
#include "two_point_search.h"

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
// Of a fit to markers that one camera alone sees: a marker taken for another is off by tenths of a pixel, too.
constexpr double kStrangerRatio = 15.0;
constexpr int kFewestMarkers = 3;
constexpr int kLongestLoss = 5;  // frames for which a track is continued without its target

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
      tracks_(targets.targets.size()),
      predicted_(targets.targets.size()),
      square_sum_(kGuessFreedoms * kGuessedCentroidSd * kGuessedCentroidSd),
      freedoms_(kGuessFreedoms) {}

double StereoCapture::centroidSd() const { return std::sqrt(square_sum_ / freedoms_); }

void StereoCapture::forget() { tracks_.assign(tracks_.size(), {}); }

void StereoCapture::predict() {
  for (std::size_t t = 0; t < tracks_.size(); ++t) {
    const auto& [last, before, lost] = tracks_[t];
    predicted_[t] = last;
    if (!last || !before) continue;
    const Eigen::Matrix3d turn = last->rotation * before->rotation.transpose();
    for (int frame = 0; frame <= lost; ++frame) {
      predicted_[t]->rotation = turn * predicted_[t]->rotation;
      predicted_[t]->origin += last->origin - before->origin;
    }
  }
}

std::array<double, 2> StereoCapture::expectedRadii() const {
  double left = 0.0, right = 0.0;
  int seen = 0;
  for (const auto& pose : predicted_) {
    if (!pose) continue;
    left += 1.0 / pose->origin.z();
    right += 1.0 / (cameras_.rotation * pose->origin + cameras_.translation).z();
    ++seen;
  }
  if (seen == 0) return {0.0, 0.0};
  const double scale = targets_.marker_radius / seen;
  return {scale * left * cameras_.left.focal(), scale * right * cameras_.right.focal()};
}

void StereoCapture::fit(std::size_t target, TargetMatch match) {
  const MarkerTarget& definition = targets_.targets[target];
  TargetFrame& frame = frame_.targets[target];
  SeenMarkers markers = seenMarkers(definition, match.candidate, frame_.points);
  RefinedPose refined = refinePose(cameras_, match.pose, markers.body, markers.seen);
  while (match.visible > kFewestMarkers) {
    const auto worst = std::max_element(refined.marker_px.begin(), refined.marker_px.end());
    std::vector<int> fewer = match.candidate;
    fewer[markers.marker[worst - refined.marker_px.begin()]] = -1;
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

void StereoCapture::follow(std::size_t target) {
  FreeBlobs left{frame_.left, std::vector<char>(frame_.left.size(), 0)};
  FreeBlobs right{frame_.right, std::vector<char>(frame_.right.size(), 0)};
  for (const TargetFrame& other : frame_.targets) {
    for (const int c : other.candidate) {
      if (c < 0) continue;
      left.used[frame_.points[c].left] = 1;
      right.used[frame_.points[c].right] = 1;
    }
  }
  const std::vector<Eigen::Vector3d>& markers = targets_.targets[target].markers;
  if (predicted_[target]) {
    const auto tracked = fitTracked(cameras_, triangulator_, markers, *predicted_[target], left, right);
    if (tracked && accept(target, *tracked)) return;
  }
  const auto found =
      findByTwoPoints(cameras_, triangulator_, markers, frame_.points, left, right, square_sum_ / freedoms_);
  if (found) accept(target, *found);
}

bool StereoCapture::accept(std::size_t target, const TrackedTarget& tracked) {
  const double own = tracked.refined.square_sum / tracked.freedoms();
  const double pooled = square_sum_ / freedoms_;
  if (own > kStrangerRatio * pooled) return false;
  TargetFrame& frame = frame_.targets[target];
  std::vector<int> candidate(frame.candidate.size(), -1);
  for (std::size_t i = 0; i < candidate.size(); ++i) {
    if (tracked.left[i] < 0 || tracked.right[i] < 0) continue;
    const auto pair = std::find_if(frame_.points.begin(), frame_.points.end(), [&](const PointCandidate& point) {
      return point.left == tracked.left[i] && point.right == tracked.right[i];
    });
    if (pair == frame_.points.end()) return false;  // the two do not meet
    candidate[i] = static_cast<int>(pair - frame_.points.begin());
  }
  const SeenMarkers markers = seenMarkers(targets_.targets[target], candidate, frame_.points);
  frame.found = true;
  frame.failure = MatchFailure::kNone;
  frame.candidate = candidate;
  frame.visible = static_cast<int>(markers.marker.size());
  frame.single = static_cast<int>(tracked.marker.size()) - frame.visible;
  frame.pose = tracked.refined.pose;
  frame.rms = fitRms(frame.pose, markers.body, markers.camera);
  for (const PointCandidate* seen : markers.seen) frame.epipolar += seen->epipolar / frame.visible;
  frame.covariance = std::max(own, pooled) * tracked.refined.cofactor;
  return true;
}

void StereoCapture::remember(std::size_t target) {
  Track& track = tracks_[target];
  if (frame_.targets[target].found) {
    track.before = track.lost == 0 ? track.last : std::nullopt;
    track.last = frame_.targets[target].pose;
    track.lost = 0;
  } else if (++track.lost > kLongestLoss) {
    track = {};
  }
}

const FramePair& StereoCapture::process(const cv::Mat& left, const cv::Mat& right) {
  const auto expectSize = [&](const cv::Mat& image, const char* side) {
    if (cameras_.size.empty() || image.size() == cameras_.size) return;
    throw DataError(fmt::format("{} image: found {}x{} px, expected {}x{} as the stereo calibration says", side,
                                image.cols, image.rows, cameras_.size.width, cameras_.size.height));
  };
  expectSize(left, "left");
  expectSize(right, "right");
  predict();
  const std::array<double, 2> radius = expectedRadii();
  frame_.left = left_blobs_.detect(left, radius[0]);
  frame_.right = right_blobs_.detect(right, radius[1]);
  frame_.rejections = {left_blobs_.rejections(), right_blobs_.rejections()};
  frame_.points = triangulator_.candidates(frame_.left, frame_.right);
  const auto& matches = matcher_.match(triangulator_, frame_.points, predicted_);
  frame_.targets.assign(targets_.targets.size(), {});
  int used = 0;
  for (std::size_t t = 0; t < matches.size(); ++t) {
    frame_.targets[t].failure = matcher_.failures()[t];
    frame_.targets[t].candidate.assign(targets_.targets[t].markers.size(), -1);
    if (matches[t]) fit(t, *matches[t]);
    used += frame_.targets[t].visible;
  }
  for (std::size_t t = 0; t < matches.size(); ++t) {
    if (!matches[t]) follow(t);
    used += frame_.targets[t].found && !matches[t] ? frame_.targets[t].visible : 0;
    remember(t);
  }
  frame_.ghosts = static_cast<int>(frame_.left.size() + frame_.right.size()) - 2 * used;
  return frame_;
}

}  // namespace simgap
