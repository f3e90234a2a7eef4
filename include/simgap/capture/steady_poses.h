/// \file
/// Where the arm rests, and what the shafts did then: a motion to a pose set.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <utility>
#include <vector>

#include "simgap/capture/joint_angles.h"
#include "simgap/core/csv.h"

namespace simgap {

struct SteadyOptions {
  double duration = 0.1;    ///< [s] a rest is at least this long (001: t_d)
  double max_speed = 0.05;  ///< [rad/s] of any joint, of a slide as JointKind::counted, by a straight line through
                            ///< `duration` (001: omega_max)
};

/// A rest of the arm.
struct SteadyPose {
  std::size_t first_frame = 0, last_frame = 0;
  double start = 0.0, end = 0.0;  ///< [s]
  std::size_t samples = 0;
  std::vector<JointPosition> joints;  ///< means (rotations: Markley)
  std::vector<double> spread;         ///< shape (joints) [rad]: standard deviation of a sample about the mean
  std::vector<double> shafts;         ///< shape (muscles) [rad], means; empty without a shaft log
};

/// Windows of `duration` in which every joint's line has a slope below max_speed and no sample strays from the mean by
/// more than max_speed * duration; windows that overlap are one rest. Keeps the samples of one window and one rest.
class RestFinder {
 public:
  RestFinder(std::vector<CaptureJoint> joints, const SteadyOptions& options);
  void add(JointSample sample);  ///< in order
  /// The rests that have ended since they were taken last.
  std::vector<SteadyPose> take() { return std::exchange(poses_, {}); }
  /// The same, of a recording that has ended.
  std::vector<SteadyPose> finish();
  std::size_t samplesKept() const { return samples_.size(); }

 private:
  std::span<const JointSample> kept(std::size_t first, std::size_t end) const;
  void closeRest();
  void forget();

  std::vector<CaptureJoint> joints_;
  SteadyOptions options_;
  std::vector<JointSample> samples_;  ///< from number begin_ on
  std::size_t begin_ = 0;
  std::size_t window_ = 0;               ///< first sample of the window that is not long enough yet
  std::size_t rest_ = 0, rest_end_ = 0;  ///< samples of the rest that is growing
  std::vector<SteadyPose> poses_;
};

/// The rests of a whole motion.
std::vector<SteadyPose> findSteadyPoses(std::span<const JointSample> samples, const std::vector<CaptureJoint>& joints,
                                        const SteadyOptions& options);

/// Shaft angles over time (columns `time_s`, `shaft_<muscle>_rad`).
struct ShaftLog {
  std::string file;
  std::vector<std::string> muscles;
  std::vector<double> times;                ///< [s], increasing
  std::vector<std::vector<double>> shafts;  ///< shape (muscles, rows) [rad]
};
/// \throws DataError: no shaft column, fewer than two rows, time that does not increase, and all that CsvTable refuses.
ShaftLog readShaftLog(const CsvTable& table);

/// Fills in the means of the shafts while the arm rested. \returns whether the log covers that.
bool joinShafts(SteadyPose& pose, const ShaftLog& log);

/// By how much the joints move after the shafts.
struct Lag {
  double seconds = 0.0;
  double correlation = 0.0;  ///< of joint and shaft speed at that lag; below kClearCorrelation the lag means nothing
  static constexpr double kClearCorrelation = 0.5;
};
/// How fast all joints or all shafts are between neighbouring rows, at the middle of each step.
struct Speeds {
  std::vector<double> times, values;  ///< shape (rows - 1) [s], [rad/s]

  double at(double time) const;  ///< straight in between; 0 outside
};
/// Of joints, sample by sample.
class JointSpeeds {
 public:
  explicit JointSpeeds(std::vector<CaptureJoint> joints) : joints_(std::move(joints)) {}
  void add(const JointSample& sample);  ///< in order
  const Speeds& speeds() const { return speeds_; }
  double step() const;  ///< mean time between samples; of two or more [s]

 private:
  std::vector<CaptureJoint> joints_;
  std::optional<JointSample> last_;
  double first_time_ = 0.0;
  Speeds speeds_;
};
/// The largest correlation of the speeds of all joints and all shafts within +- `range` [s].
Lag estimateLag(const JointSpeeds& joints, const ShaftLog& log, double range);

/// The pose set (docs/formats.md): pose, repeat, time_s, shafts, joints; then per joint its standard deviation, and the
/// number of samples.
CsvWriter posesCsv(const std::vector<CaptureJoint>& joints, const std::vector<std::string>& muscles);
void addPose(CsvWriter& csv, std::size_t number, const SteadyPose& pose, const std::vector<CaptureJoint>& joints);

}  // namespace simgap
