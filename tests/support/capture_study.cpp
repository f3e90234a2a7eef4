#include "support/capture_study.h"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numeric>

#include "simgap/core/rotation.h"

namespace simgap::test {
namespace {

using reality::ArmPose;

/// The humerus turns the shoulder, the forearm the elbow; the camera's axes are those of the stage.
Eigen::Matrix3d trueRotation(std::size_t target, const ArmPose& pose) {
  Eigen::Matrix3d camera;
  camera << 1, 0, 0, 0, 0, -1, 0, 1, 0;
  if (target >= 1) camera = camera * pose.shoulder.toRotationMatrix();
  if (target >= 2) camera = camera * Eigen::AngleAxisd(pose.elbow, Eigen::Vector3d::UnitX()).toRotationMatrix();
  return camera;
}

Eigen::Vector3d rotationVector(const Eigen::Matrix3d& rotation) {
  const Eigen::AngleAxisd turn(rotation);
  return turn.angle() * turn.axis();
}

/// What an exposure shows is the mean over it; at the corner of a path that is not the pose in its middle.
ArmPose meanOf(const std::vector<ArmPose>& poses) {
  ArmPose mean{Eigen::Quaterniond(0, 0, 0, 0), 0.0};
  for (const ArmPose& pose : poses) {
    mean.shoulder.coeffs() += pose.shoulder.coeffs() * (pose.shoulder.dot(poses[0].shoulder) < 0.0 ? -1.0 : 1.0);
    mean.elbow += pose.elbow / double(poses.size());
  }
  mean.shoulder.normalize();
  return mean;
}

class Judge {
 public:
  Judge(const reality::CaptureStage& stage) : stage_(stage) {}

  void add(const FramePair& frame, const reality::RenderedPair& truth, const ArmPose& pose) {
    ++result.pairs;
    const bool whole = allInView(truth);
    result.whole_pairs += whole;
    for (std::size_t t = 0; t < frame.targets.size(); ++t) {
      const bool visible = markersInView(truth, t) >= 3;
      result.visible_targets += visible;
      const TargetFrame& target = frame.targets[t];
      if (!target.found) continue;
      result.found_targets += visible;
      for (std::size_t i = 0; i < target.candidate.size(); ++i) checkIdentity(frame, truth, t, i);
      fit_squares_ += target.rms * target.rms;
      ++fits_;
      const Eigen::Vector3d turn = rotationVector(target.pose.rotation * trueRotation(t, pose).transpose());
      const Eigen::Vector3d shift = target.pose * stage_.targets()[t].markers[0] - truth.markers[t][0];
      shift_squares_ += shift.squaredNorm();
      addSpread(target, turn, shift, target.pose.rotation * stage_.targets()[t].markers[0]);
      turns_.resize(3);
      turns_[t] = target.pose.rotation;
    }
    if (!std::all_of(frame.targets.begin(), frame.targets.end(), [](const auto& f) { return f.found; })) return;
    result.captured_pairs += whole;
    const Eigen::Matrix3d shoulder = turns_[0].transpose() * turns_[1];
    const Eigen::Matrix3d elbow = turns_[1].transpose() * turns_[2];
    const Eigen::AngleAxisd flexion(pose.elbow, Eigen::Vector3d::UnitX());
    const Eigen::Vector3d shoulder_error = rotationVector(shoulder * pose.shoulder.toRotationMatrix().transpose());
    const Eigen::Vector3d elbow_error = rotationVector(elbow * flexion.toRotationMatrix().transpose());
    shoulder_squares_ += shoulder_error.squaredNorm();
    forearm_squares_ += elbow_error.squaredNorm();
    elbow_squares_ += elbow_error.x() * elbow_error.x();
    ++arms_;
  }

  StudyResult result;
  void finish() {
    const auto rms = [](double squares, double n) { return n > 0 ? std::sqrt(squares / n) : 0.0; };
    result.fit_rms = rms(fit_squares_, fits_);
    result.shoulder_deg = toDegrees(rms(shoulder_squares_, arms_));
    result.elbow_deg = toDegrees(rms(elbow_squares_, arms_));
    result.relative_deg = toDegrees(rms(shoulder_squares_ + forearm_squares_, 2.0 * arms_));
    result.position_rms = rms(shift_squares_, 3.0 * fits_);
    result.sd_ratio = rms(normalized_squares_, normalized_);
  }

 private:
  void checkIdentity(const FramePair& frame, const reality::RenderedPair& truth, std::size_t t, std::size_t i) {
    const int c = frame.targets[t].candidate[i];
    if (c < 0) return;
    const PointCandidate& point = frame.points[std::size_t(c)];
    const reality::StereoLenses& lenses = stage_.lenses();
    const Eigen::Vector3d p = truth.markers[t][i];
    const double left = (frame.left[std::size_t(point.left)].centre - lenses.left.project(p)).norm();
    const double right =
        (frame.right[std::size_t(point.right)].centre - lenses.right.project(lenses.rotation * p + lenses.translation))
            .norm();
    const double radius = 0.5 * 0.012 * lenses.left.fx / p.z();
    result.wrong_identities += left > radius || right > radius || !truth.visible[t][i];
  }

  /// Markers that are drawn, well inside both images, and not touched by another one in either.
  int markersInView(const reality::RenderedPair& truth, std::size_t t) const {
    int count = 0;
    for (std::size_t i = 0; i < truth.markers[t].size(); ++i) {
      count += truth.visible[t][i] && standsFree(truth, t, i, false) && standsFree(truth, t, i, true);
    }
    return count;
  }

  bool allInView(const reality::RenderedPair& truth) const {
    for (std::size_t t = 0; t < truth.markers.size(); ++t) {
      for (std::size_t i = 0; i < truth.markers[t].size(); ++i) {
        if (!truth.visible[t][i] || !insideImage(truth.markers[t][i], false)) return false;
        if (!insideImage(truth.markers[t][i], true)) return false;
      }
    }
    return true;
  }

  Eigen::Vector2d pixel(const Eigen::Vector3d& p, bool right) const {
    const reality::StereoLenses& lenses = stage_.lenses();
    return right ? lenses.right.project(lenses.rotation * p + lenses.translation) : lenses.left.project(p);
  }

  bool insideImage(const Eigen::Vector3d& marker, bool right) const {
    const reality::Lens& lens = right ? stage_.lenses().right : stage_.lenses().left;
    const Eigen::Vector2d at = pixel(marker, right);
    const double margin = 10.0 * lens.width / 640.0;
    return at.x() > margin && at.y() > margin && at.x() < lens.width - margin && at.y() < lens.height - margin;
  }

  bool standsFree(const reality::RenderedPair& truth, std::size_t t, std::size_t i, bool right) const {
    const double focal = (right ? stage_.lenses().right : stage_.lenses().left).fx;
    const Eigen::Vector2d at = pixel(truth.markers[t][i], right);
    const double touching = 0.012 * focal / truth.markers[t][i].z() + 4.0;
    for (std::size_t other = 0; other < truth.markers.size(); ++other) {
      for (std::size_t k = 0; k < truth.markers[other].size(); ++k) {
        if ((other == t && k == i) || !truth.visible[other][k]) continue;
        if ((pixel(truth.markers[other][k], right) - at).norm() < touching) return false;
      }
    }
    return insideImage(truth.markers[t][i], right);
  }

  /// Errors over their reported standard deviations: rotation and position of the first marker, each axis.
  void addSpread(const TargetFrame& target, const Eigen::Vector3d& turn, const Eigen::Vector3d& shift,
                 const Eigen::Vector3d& arm) {
    Eigen::Matrix<double, 3, 6> towards;
    towards << 0, arm.z(), -arm.y(), 1, 0, 0, -arm.z(), 0, arm.x(), 0, 1, 0, arm.y(), -arm.x(), 0, 0, 0, 1;
    const Eigen::Matrix3d position = towards * target.covariance * towards.transpose();
    for (int k = 0; k < 3; ++k) {
      normalized_squares_ += turn[k] * turn[k] / target.covariance(k, k) + shift[k] * shift[k] / position(k, k);
      normalized_ += 2.0;
    }
  }

  const reality::CaptureStage& stage_;
  std::vector<Eigen::Matrix3d> turns_;
  double fit_squares_ = 0, fits_ = 0, shoulder_squares_ = 0, elbow_squares_ = 0, forearm_squares_ = 0, arms_ = 0;
  double shift_squares_ = 0, normalized_squares_ = 0, normalized_ = 0;
};

}  // namespace

StereoCameras camerasOf(const reality::StereoLenses& lenses) {
  return readStereo(reality::stereoYaml(lenses), "stereo.yaml");
}

TargetSet targetsOf(const std::vector<reality::MarkerTarget>& targets, double radius) {
  return readTargets(YamlNode::parse(reality::targetsYaml(targets, radius), "targets.yaml"));
}

cv::Mat matOf(const reality::Image& image) {
  return {image.height, image.width, CV_8UC1, const_cast<std::uint8_t*>(image.pixels.data())};
}

StudyResult runStudy(const StudyOptions& options) {
  const reality::CaptureStage stage(
      reality::standardLenses(options.scale),
      options.targets == 0 ? reality::standardTargets() : reality::drawnTargets(options.targets), {}, options.radius);
  StereoCapture capture(camerasOf(stage.lenses()), targetsOf(stage.targets(), options.radius));
  Judge judge(stage);
  std::vector<double> times;
  const auto drawn = options.wide ? reality::widePose : reality::randomPose;
  for (int n = 0; n < options.pairs; ++n) {
    const std::uint64_t seed = options.seed * 1000003 + std::uint64_t(n);
    constexpr int kPerLeg = 30;  // frames from one pose to the next: 0.5 s at 60 Hz
    const auto at = [&](double frame) {
      const auto leg = std::uint64_t(frame / kPerLeg);
      return reality::between(drawn(options.seed * 77 + leg), drawn(options.seed * 77 + leg + 1),
                              frame / kPerLeg - double(leg));
    };
    std::vector<ArmPose> poses;
    for (int e = 0; e < options.exposures; ++e) {
      const double moment = n + 0.3 * (options.exposures > 1 ? e / (options.exposures - 1.0) - 0.5 : 0.0);
      poses.push_back(options.rest > 0   ? drawn(options.seed * 1000003 + std::uint64_t(n / options.rest))
                      : options.sequence ? at(std::max(0.0, moment))
                                         : drawn(seed));
    }
    const ArmPose mean = meanOf(poses);
    reality::RenderedPair pair = stage.render(poses, options.disturbance, seed);
    pair.markers = reality::markersInLeft(stage.targets(), mean);
    const cv::Mat left = matOf(pair.left);
    const cv::Mat right = matOf(pair.right);
    const std::clock_t start = std::clock();
    const FramePair& frame = capture.process(left, right);
    times.push_back(1e3 * double(std::clock() - start) / CLOCKS_PER_SEC);
    judge.add(frame, pair, mean);
    if (!options.sequence && options.rest == 0) capture.forget();
  }
  judge.result.mean_ms = std::accumulate(times.begin(), times.end(), 0.0) / double(times.size());
  std::nth_element(times.begin(), times.begin() + std::ptrdiff_t(times.size() / 2), times.end());
  judge.result.process_ms = times[times.size() / 2];
  judge.finish();
  return judge.result;
}

std::string describe(const std::string& name, const StudyResult& r) {
  char text[500];
  std::snprintf(text, sizeof text,
                "%-34s pairs %4d  wrong %d  found %d/%d (%.2f %%)  whole %d/%d (%.2f %%)  fit RMS %.4f mm  relative "
                "%.4f deg  shoulder %.4f  "
                "elbow %.4f  position %.4f mm  spread/sd %.3f  %.3f ms",
                name.c_str(), r.pairs, r.wrong_identities, r.found_targets, r.visible_targets,
                100.0 * r.found_targets / std::max(1, r.visible_targets), r.captured_pairs, r.whole_pairs,
                100.0 * r.captured_pairs / std::max(1, r.whole_pairs), 1e3 * r.fit_rms, r.relative_deg, r.shoulder_deg,
                r.elbow_deg, 1e3 * r.position_rms, r.sd_ratio, r.process_ms);
  return text;
}

}  // namespace simgap::test
