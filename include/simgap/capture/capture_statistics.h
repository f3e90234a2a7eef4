/// \file
/// What a run of the capture says about itself, and whether the geometry can be believed.
#pragma once

#include <array>
#include <string>
#include <vector>

#include "simgap/capture/stereo_capture.h"

namespace simgap {

/// Mean and variance of a stream (Welford).
class RunningStatistics {
 public:
  void add(double value) {
    ++count_;
    const double step = value - mean_;
    mean_ += step / static_cast<double>(count_);
    squares_ += step * (value - mean_);
  }
  std::size_t count() const { return count_; }
  double mean() const { return mean_; }
  double sd() const;
  double rms() const;

 private:
  std::size_t count_ = 0;
  double mean_ = 0.0;
  double squares_ = 0.0;
};

/// The distance of two markers of a target.
struct DistanceStatistics {
  int target = 0;
  std::array<int, 2> markers{};
  double nominal = 0.0;        ///< [m] by the target file
  RunningStatistics measured;  ///< [m]
  RunningStatistics variance;  ///< [m^2] as the noise of the blobs predicts it
};

/// One reason to doubt the geometry.
struct GeometryFinding {
  std::string name;      ///< "scale-bar", "scale-across", "scale-along", "distance-spread", "epipolar"
  std::string sentence;  ///< with figures
};

/// Relative errors of lengths across and along the line of sight, by least squares over all distances: a camera turned
/// inwards and a focal length that is off can cancel in their mean, never in both.
class DirectionalScale {
 public:
  struct Estimate {
    Eigen::Vector2d error = Eigen::Vector2d::Zero();  ///< across, along (1)
    Eigen::Vector2d sd = Eigen::Vector2d::Zero();
  };
  /// \param towards  cosine of the distance's direction to the line of sight.
  void add(double measured, double nominal, double towards);
  Estimate estimate() const;

 private:
  Eigen::Matrix2d matrix_ = Eigen::Matrix2d::Zero();
  Eigen::Vector2d right_ = Eigen::Vector2d::Zero();
  double squares_ = 0.0;
  std::size_t count_ = 0;
};

/// Histogram of distance errors, in steps of kStep from -kRange to kRange [m].
struct DistanceHistogram {
  static constexpr double kStep = 0.02e-3;
  static constexpr int kBins = 50;  ///< the outer ones hold all that is further out
  std::array<long, kBins> counts{};
  void add(double error);
};

class CaptureStatistics {
 public:
  CaptureStatistics(const StereoCameras& cameras, const TargetSet& targets, const Rig& rig);
  void add(const FramePair& frame, double centroid_sd);

  std::size_t frames() const { return frames_; }
  std::size_t found(std::size_t target) const { return rms_[target].count(); }
  const RunningStatistics& rms(std::size_t target) const { return rms_[target]; }          ///< [m]
  const RunningStatistics& markers(std::size_t target) const { return markers_[target]; }  ///< seen when found
  const RunningStatistics& ghosts() const { return ghosts_; }
  const RunningStatistics& epipolar() const { return epipolar_; }   ///< [px] signed, of every marker used
  const BlobRejections& rejections() const { return rejections_; }  ///< of all images
  const RunningStatistics& blobs(int side) const { return blobs_[side]; }
  const std::vector<DistanceStatistics>& distances() const { return distances_; }
  const DistanceHistogram& histogram() const { return histogram_; }
  const RunningStatistics& scaleBar() const { return scale_bar_; }  ///< [m]
  std::size_t ambiguous(std::size_t target) const { return ambiguous_[target]; }
  double centroidSd() const { return centroid_sd_; }  ///< [px]
  const DirectionalScale& scales() const { return scales_; }
  /// Measured by nominal distances of all markers, in percent - 100.
  double scaleErrorPercent() const;

  /// A small fit error does not prove geometry: a camera turned by 0.6 mrad still fits to 0.25 mm. What betrays it: the
  /// scale bar, the scale of all distances across and along the line of sight, distances that change with the place, a
  /// bias of the epipolar error.
  std::vector<GeometryFinding> doubts() const;

 private:
  void addDistances(const FramePair& frame, double centroid_sd);
  void addScaleBar(const FramePair& frame);

  const StereoCameras cameras_;
  const TargetSet targets_;
  const Rig rig_;
  Triangulator triangulator_;
  Eigen::Vector3d middle_;  ///< between the cameras [m]
  std::size_t frames_ = 0;
  std::vector<RunningStatistics> rms_, markers_;
  std::vector<std::size_t> ambiguous_;
  RunningStatistics ghosts_, epipolar_;
  BlobRejections rejections_;
  std::array<RunningStatistics, 2> blobs_;
  std::vector<DistanceStatistics> distances_;
  std::vector<std::size_t> first_distance_;  ///< per target: index into distances_
  DistanceHistogram histogram_;
  DirectionalScale scales_;
  RunningStatistics scale_bar_;
  double centroid_sd_ = 0.0;
};

}  // namespace simgap
