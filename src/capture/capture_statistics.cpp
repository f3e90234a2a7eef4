#include "simgap/capture/capture_statistics.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

namespace simgap {
namespace {

// A deviation is reported when it is both significant and large enough to matter.
constexpr double kSignificance = 4.0;        // standard errors
constexpr double kScaleTolerance = 1e-3;     // of a length
constexpr double kSpreadTolerance = 1.5;     // observed by predicted standard deviation of a distance
constexpr double kDisturbed = 1.5;           // Blob::spread of a marker that others touch or cover
constexpr double kSpreadFloor = 0.05e-3;     // [m] of additional spread
constexpr double kEpipolarTolerance = 0.05;  // [px] mean of the signed error
constexpr std::size_t kFewestForStatistics = 10;

/// A marker that another one covers in part says nothing of the geometry of the cameras.
bool isUndisturbed(const PointCandidate& point) {
  return point.left_spread < kDisturbed && point.right_spread < kDisturbed;
}

double standardError(const RunningStatistics& s) { return s.sd() / std::sqrt(static_cast<double>(s.count())); }

}  // namespace

double RunningStatistics::sd() const {
  return count_ > 1 ? std::sqrt(squares_ / static_cast<double>(count_ - 1)) : 0.0;
}

double RunningStatistics::rms() const {
  return count_ > 0 ? std::sqrt(mean_ * mean_ + squares_ / static_cast<double>(count_)) : 0.0;
}

void DirectionalScale::add(double measured, double nominal, double towards) {
  const Eigen::Vector2d basis = nominal * Eigen::Vector2d(1.0 - towards * towards, towards * towards);
  const double error = measured - nominal;
  matrix_ += basis * basis.transpose();
  right_ += basis * error;
  squares_ += error * error;
  ++count_;
}

DirectionalScale::Estimate DirectionalScale::estimate() const {
  if (count_ < 10 || matrix_.determinant() <= 0.0) return {};
  Estimate e;
  e.error = matrix_.inverse() * right_;
  const double variance = std::max(0.0, squares_ - e.error.dot(right_)) / static_cast<double>(count_ - 2);
  e.sd = (variance * matrix_.inverse().diagonal()).cwiseSqrt();
  return e;
}

void DistanceHistogram::add(double error) {
  const double bin = std::floor(error / kStep) + kBins / 2;
  ++counts[static_cast<std::size_t>(std::clamp(bin, 0.0, kBins - 1.0))];
}

CaptureStatistics::CaptureStatistics(const StereoCameras& cameras, const TargetSet& targets, const Rig& rig)
    : cameras_(cameras),
      targets_(targets),
      rig_(rig),
      triangulator_(cameras, targets.marker_radius, 1.0),
      middle_(-0.5 * cameras.rotation.transpose() * cameras.translation),
      rms_(targets.targets.size()),
      markers_(targets.targets.size()),
      ambiguous_(targets.targets.size()) {
  for (std::size_t t = 0; t < targets.targets.size(); ++t) {
    first_distance_.push_back(distances_.size());
    const auto& markers = targets.targets[t].markers;
    for (std::size_t i = 0; i < markers.size(); ++i) {
      for (std::size_t j = 0; j < i; ++j) {
        distances_.push_back({static_cast<int>(t),
                              {static_cast<int>(j), static_cast<int>(i)},
                              (markers[i] - markers[j]).norm(),
                              {},
                              {}});
      }
    }
  }
}

void CaptureStatistics::addDistances(const FramePair& frame, double centroid_sd) {
  for (DistanceStatistics& distance : distances_) {
    const TargetFrame& target = frame.targets[distance.target];
    if (!target.found) continue;
    const int a = target.candidate[distance.markers[0]];
    const int b = target.candidate[distance.markers[1]];
    if (a < 0 || b < 0) continue;
    if (!isUndisturbed(frame.points[a]) || !isUndisturbed(frame.points[b])) continue;
    const Eigen::Vector3d& p = frame.points[a].point;
    const Eigen::Vector3d& q = frame.points[b].point;
    const double length = (p - q).norm();
    const Eigen::Vector3d along = (p - q) / length;
    const Eigen::Matrix3d covariance =
        triangulator_.covariancePerPixel(frame.points[a]) + triangulator_.covariancePerPixel(frame.points[b]);
    distance.measured.add(length);
    distance.variance.add(centroid_sd * centroid_sd * along.dot(covariance * along));
    histogram_.add(length - distance.nominal);
    scales_.add(length, distance.nominal, along.dot((p - middle_).normalized()));
  }
}

void CaptureStatistics::addScaleBar(const FramePair& frame) {
  if (!rig_.scale_bar) return;
  std::array<Eigen::Vector3d, 2> ends;
  for (std::size_t e = 0; e < 2; ++e) {
    const TargetFrame& target = frame.targets[rig_.scale_bar->target[e]];
    if (!target.found) return;
    const int candidate = target.candidate[rig_.scale_bar->marker[e]];
    if (candidate < 0 || !isUndisturbed(frame.points[candidate])) return;
    ends[e] = frame.points[candidate].point;
  }
  scale_bar_.add((ends[0] - ends[1]).norm());
}

void CaptureStatistics::add(const FramePair& frame, double centroid_sd) {
  ++frames_;
  centroid_sd_ = centroid_sd;
  blobs_[0].add(static_cast<double>(frame.left.size()));
  blobs_[1].add(static_cast<double>(frame.right.size()));
  ghosts_.add(frame.ghosts);
  for (const BlobRejections& rejected : frame.rejections) {
    rejections_.area += rejected.area;
    rejections_.circularity += rejected.circularity;
    rejections_.edge += rejected.edge;
  }
  for (std::size_t t = 0; t < frame.targets.size(); ++t) {
    const TargetFrame& target = frame.targets[t];
    ambiguous_[t] += target.failure == MatchFailure::kAmbiguous;
    if (!target.found) continue;
    rms_[t].add(target.rms);
    markers_[t].add(target.visible);
    for (const int c : target.candidate) {
      if (c >= 0 && isUndisturbed(frame.points[c])) epipolar_.add(frame.points[c].epipolar);
    }
  }
  addDistances(frame, centroid_sd);
  addScaleBar(frame);
}

double CaptureStatistics::scaleErrorPercent() const {
  double along = 0.0;
  double nominal = 0.0;
  for (const DistanceStatistics& d : distances_) {
    if (d.measured.count() == 0) continue;
    along += d.measured.mean() * d.nominal;
    nominal += d.nominal * d.nominal;
  }
  return nominal > 0.0 ? 100.0 * (along / nominal - 1.0) : 0.0;
}

std::vector<GeometryFinding> CaptureStatistics::doubts() const {
  std::vector<GeometryFinding> findings;
  if (rig_.scale_bar && scale_bar_.count() > 0) {
    const double length = rig_.scale_bar->length;
    const double off = scale_bar_.mean() - length;
    if (std::abs(off) > kSignificance * standardError(scale_bar_) && std::abs(off) > kScaleTolerance * length) {
      findings.push_back({"scale-bar", fmt::format("the scale bar measures {:.3f} mm, expected {:.3f} mm ({:+.2f} %)",
                                                   1e3 * scale_bar_.mean(), 1e3 * length, 100.0 * off / length)});
    }
  }
  const DirectionalScale::Estimate scale = scales_.estimate();
  for (const int k : {0, 1}) {
    if (std::abs(scale.error[k]) > kScaleTolerance && std::abs(scale.error[k]) > kSignificance * scale.sd[k]) {
      findings.push_back(
          {k == 0 ? "scale-across" : "scale-along",
           fmt::format("distances {} the line of sight are {:+.2f} % +- {:.2f} of those in the target file",
                       k == 0 ? "across" : "along", 100.0 * scale.error[k], 100.0 * scale.sd[k])});
    }
  }
  double observed = 0.0;
  double predicted = 0.0;
  for (const DistanceStatistics& d : distances_) {
    if (d.measured.count() < kFewestForStatistics) continue;
    observed += d.measured.sd() * d.measured.sd();
    predicted += d.variance.mean();
  }
  const bool wide = observed > kSpreadTolerance * kSpreadTolerance * predicted;
  const auto pairs = static_cast<double>(std::max<std::size_t>(1, distances_.size()));
  if (wide && observed - predicted > pairs * kSpreadFloor * kSpreadFloor) {
    findings.push_back(
        {"distance-spread",
         fmt::format("distances of a rigid target vary by {:.3f} mm, expected {:.3f} mm from noise: they "
                     "depend on the place",
                     1e3 * std::sqrt(observed / pairs), 1e3 * std::sqrt(predicted / pairs))});
  }
  if (epipolar_.count() > kFewestForStatistics && std::abs(epipolar_.mean()) > kEpipolarTolerance &&
      std::abs(epipolar_.mean()) > kSignificance * standardError(epipolar_)) {
    findings.push_back(
        {"epipolar", fmt::format("markers miss their epipolar lines by {:+.2f} px on average, expected 0 "
                                 "within {:.2f} px",
                                 epipolar_.mean(), kEpipolarTolerance)});
  }
  return findings;
}

}  // namespace simgap
