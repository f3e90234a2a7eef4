/// \file
/// How far a played motion is from the recorded one, channel by channel.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "simgap/simulate/motion_player.h"

namespace simgap {

/// What a recording measures over time.
enum class ChannelGroup { kJoint, kShaft, kCurrent };

/// One channel of one motion. Angles of a ball are per component: the root mean square over its three axes.
struct ChannelError {
  ChannelGroup group;
  std::size_t item;           ///< joint or muscle
  double rms = 0.0;           ///< [rad, m or A]
  double worst_second = 0.0;  ///< the largest root mean square of any second of it
  double worst_at = 0.0;      ///< where that second begins [s]
  /// By how much the simulation is late, where its own movement explains the error best; NaN: it does not move [s].
  double lag = 0.0;
};

/// Simulated minus measured over time.
struct ErrorSeries {
  ChannelGroup group;
  std::size_t item;
  std::vector<double> times;                ///< shape (samples) [s]
  std::vector<Eigen::Vector3d> errors;      ///< shape (samples); components that a channel does not have are 0
  std::vector<Eigen::Vector3d> velocities;  ///< of the simulation, the same way [per second]
  int components = 1;
};

/// All measured channels of a motion. \param played  valid, of this motion
std::vector<ErrorSeries> errorSeries(const RecordedMotion& motion, const PlayedMotion& played,
                                     const PoseLayout& layout);
ChannelError summarise(const ErrorSeries& series);

/// Root mean squares over all samples of motions; NaN: nothing was measured.
struct MotionRms {
  std::vector<double> joints;  ///< shape (joints) [rad], of a slide [m], per component
  double shafts, currents;     ///< [rad], [A]
};
/// \param played  shape (motions); one that could not be played makes all NaN
MotionRms motionRms(std::span<const RecordedMotion> motions, std::span<const PlayedMotion> played,
                    const PoseLayout& layout);

/// Plays motions in parallel, among all ranks, each once; the same for any number of threads and ranks.
/// \throws InterruptedError
std::vector<PlayedMotion> playAll(const ArmModel& model, std::span<const RecordedMotion> motions,
                                  const MotionOptions& options, double capture_delay = 0.0);

}  // namespace simgap
