/// \file
/// What separates a played motion from the recorded one, as numbers with known standard deviations.
///
/// Each channel (a joint, a shaft, a current) is averaged over windows of 50 ms, simulated and measured alike; a window
/// counts by
///
///     sd^2 = noise^2 / n + discrepancy^2 tau / window,    n: samples in it
///
/// The discrepancy is what even the right parameters leave (step error, friction that is not quite Coulomb's): it lasts
/// tau = 0.3 s, so that many windows say no more about it than one. All are fixed before a fit: weights from the
/// residuals of a wrong model would hide what is wrong with it.
#pragma once

#include <Eigen/Core>
#include <vector>

#include "simgap/measure/motion_noise.h"
#include "simgap/simulate/motion_error.h"

namespace simgap {

/// What even the right parameters leave.
struct MotionDiscrepancy {
  double joints = 0.03 * kDegree;  ///< per component [rad]
  double slides = 1e-4;            ///< [m]
  double shafts = 0.03 * kDegree;  ///< [rad]
  double currents = 0.02;          ///< [A]
};

/// Where each residual of a motion comes from.
struct ResidualBlock {
  ChannelGroup group;
  std::size_t item;        ///< joint or muscle
  double time;             ///< of the window's middle, on the channel's clock [s]
  Eigen::Index first;      ///< of its numbers
  Eigen::Index size;       ///< 1, or 3 of a ball
  std::size_t begin, end;  ///< samples averaged
  double sd;               ///< of each of its numbers [rad, m or A]
  double noise_share;      ///< of its variance: what is noise's, and no discrepancy's
};

/// The residuals of one motion.
class MotionResiduals {
 public:
  static constexpr double kWindow = 0.05;  ///< over which channels are averaged [s]

  /// \param motion  must outlive it
  MotionResiduals(const RecordedMotion& motion, const PoseLayout& layout, const MotionNoise& noise,
                  const MotionDiscrepancy& discrepancy);

  const RecordedMotion& motion() const { return *motion_; }
  const std::vector<ResidualBlock>& blocks() const { return blocks_; }
  Eigen::Index size() const { return size_; }
  /// When a share of what is compared is over, on the motion's clock [s].
  double timeAt(double share) const;
  /// Whitened simulated minus measured, shape (size()); 0 in windows that were not played to their end.
  /// \param played  valid, of this motion
  void evaluate(const PlayedMotion& played, Eigen::Ref<Eigen::VectorXd> residuals) const;

 private:
  void addBlocks(ChannelGroup group, std::size_t item, const std::vector<double>& times, Eigen::Index size,
                 double noise, double discrepancy);

  const RecordedMotion* motion_;
  std::vector<JointType> types_;
  std::vector<ResidualBlock> blocks_;
  Eigen::Index size_ = 0;
};

}  // namespace simgap
