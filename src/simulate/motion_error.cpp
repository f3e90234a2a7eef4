#include "simgap/simulate/motion_error.h"

#include <tbb/enumerable_thread_specific.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <optional>

#include "simgap/core/interrupt.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/ranks.h"

namespace simgap {
namespace {

constexpr double kUnknown = std::numeric_limits<double>::quiet_NaN();

double meanSquare(const ErrorSeries& series, std::size_t begin, std::size_t end) {
  double sum = 0.0;
  for (std::size_t i = begin; i < end; ++i) sum += series.errors[i].squaredNorm();
  return sum / (static_cast<double>(end - begin) * series.components);
}

/// A simulation that is late by L has the error -L dx/dt: L by least squares, from what is not constant in the error.
double lagOf(const ErrorSeries& series) {
  constexpr double kTooSlow = 1e-3;  // root mean square velocity: noise alone would tell the lag [per second]
  constexpr double kTooLate = 0.25;  // no delay, but another movement [s]
  Eigen::Vector3d mean = Eigen::Vector3d::Zero(), mean_velocity = Eigen::Vector3d::Zero();
  const auto n = static_cast<double>(series.times.size());
  for (std::size_t i = 0; i < series.times.size(); ++i) {
    mean += series.errors[i] / n;
    mean_velocity += series.velocities[i] / n;
  }
  double product = 0.0, square = 0.0;
  for (std::size_t i = 0; i < series.times.size(); ++i) {
    const Eigen::Vector3d velocity = series.velocities[i] - mean_velocity;
    product += velocity.dot(series.errors[i] - mean);
    square += velocity.squaredNorm();
  }
  const double lag = -product / square;
  return square > kTooSlow * kTooSlow * n && std::abs(lag) < kTooLate ? lag : kUnknown;
}

ErrorSeries jointSeries(const RecordedMotion& motion, const PlayedMotion& played, std::size_t joint, JointType type,
                        std::size_t joints) {
  const JointKind& kind = kindOf(type);
  ErrorSeries series{ChannelGroup::kJoint, joint, motion.joint_times, {}, {}, kind.degrees_of_freedom};
  const std::size_t frames = motion.joint_times.size();
  for (std::size_t f = 0; f < frames; ++f) {
    const std::size_t before = f > 0 ? f - 1 : 0, after = f + 1 < frames ? f + 1 : f;
    const JointPosition& simulated = played.joints[f * joints + joint];
    series.errors.push_back(kind.difference(motion.joints[f][joint], simulated));
    series.velocities.push_back(
        kind.difference(played.joints[before * joints + joint], played.joints[after * joints + joint]) /
        (motion.joint_times[after] - motion.joint_times[before]));
  }
  return series;
}

ErrorSeries driveSeries(ChannelGroup group, std::size_t muscle, const std::vector<double>& times,
                        const std::vector<double>& measured, const Eigen::MatrixXd& simulated) {
  ErrorSeries series{group, muscle, times, {}, {}, 1};
  const auto m = static_cast<Eigen::Index>(muscle);
  const Eigen::Index rows = std::ssize(times);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const Eigen::Index before = std::max<Eigen::Index>(row - 1, 0), after = std::min(row + 1, rows - 1);
    const auto at = [&](Eigen::Index i) { return times[i]; };
    series.errors.emplace_back(simulated(m, row) - measured[row], 0.0, 0.0);
    series.velocities.emplace_back((simulated(m, after) - simulated(m, before)) / (at(after) - at(before)), 0.0, 0.0);
  }
  return series;
}

void leaveOutRunUp(double until, ErrorSeries& series) {
  const auto count = std::ranges::lower_bound(series.times, until) - series.times.begin();
  series.times.erase(series.times.begin(), series.times.begin() + count);
  series.errors.erase(series.errors.begin(), series.errors.begin() + count);
  series.velocities.erase(series.velocities.begin(), series.velocities.begin() + count);
}

struct Sum {
  double squares = 0.0, numbers = 0.0;
  void add(const ErrorSeries& series) {
    numbers += static_cast<double>(series.times.size()) * series.components;
    for (const Eigen::Vector3d& error : series.errors) squares += error.squaredNorm();
  }
  double rms() const { return std::sqrt(squares / numbers); }  // 0 / 0: NaN
};

}  // namespace

std::vector<ErrorSeries> errorSeries(const RecordedMotion& motion, const PlayedMotion& played,
                                     const PoseLayout& layout) {
  std::vector<ErrorSeries> all;
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    all.push_back(jointSeries(motion, played, j, layout.joints[j].type, layout.joints.size()));
  }
  for (std::size_t m = 0; m < layout.muscles.size(); ++m) {
    const MuscleRecord& muscle = motion.muscles[m];
    if (!muscle.shafts.empty()) {
      all.push_back(driveSeries(ChannelGroup::kShaft, m, motion.times(), muscle.shafts, played.shafts));
    }
    if (!muscle.currents.empty()) {
      all.push_back(driveSeries(ChannelGroup::kCurrent, m, motion.times(), muscle.currents, played.currents));
    }
  }
  for (ErrorSeries& series : all) leaveOutRunUp(motion.compared_from, series);
  std::erase_if(all, [](const ErrorSeries& series) { return series.times.empty(); });
  return all;
}

ChannelError summarise(const ErrorSeries& series) {
  constexpr double kSecond = 1.0;
  const std::size_t samples = series.times.size();
  ChannelError error{series.group, series.item,          std::sqrt(meanSquare(series, 0, samples)),
                     0.0,          series.times.front(), lagOf(series)};
  std::size_t end = 0;
  for (std::size_t begin = 0; begin < samples && end < samples; ++begin) {
    while (end < samples && series.times[end] < series.times[begin] + kSecond) ++end;
    const double rms = std::sqrt(meanSquare(series, begin, end));
    if (rms <= error.worst_second) continue;
    error.worst_second = rms;
    error.worst_at = series.times[begin];
  }
  return error;
}

MotionRms motionRms(std::span<const RecordedMotion> motions, std::span<const PlayedMotion> played,
                    const PoseLayout& layout) {
  MotionRms rms{std::vector<double>(layout.joints.size(), kUnknown), kUnknown, kUnknown};
  std::vector<Sum> joints(layout.joints.size());
  Sum shafts, currents;
  for (std::size_t i = 0; i < motions.size(); ++i) {
    if (!played[i].valid) return rms;
    for (const ErrorSeries& series : errorSeries(motions[i], played[i], layout)) {
      (series.group == ChannelGroup::kJoint   ? joints[series.item]
       : series.group == ChannelGroup::kShaft ? shafts
                                              : currents)
          .add(series);
    }
  }
  for (std::size_t j = 0; j < joints.size(); ++j) rms.joints[j] = joints[j].rms();
  rms.shafts = shafts.rms();
  rms.currents = currents.rms();
  return rms;
}

std::vector<PlayedMotion> playAll(const ArmModel& model, std::span<const RecordedMotion> motions,
                                  const MotionOptions& options, double capture_delay) {
  std::vector<PlayedMotion> played(motions.size());
  tbb::enumerable_thread_specific<std::optional<MotionPlayer>> players;
  computeOnRanks(std::span(played), [&](std::size_t i) {
    PlayedMotion one;
    if (interruptRequested()) return one;
    std::optional<MotionPlayer>& player = players.local();
    if (!player) player.emplace(model, options);
    player->play(PlayableMotion(motions[i], model.joints), capture_delay, one);
    return one;
  });
  stopIfInterrupted();
  return played;
}

}  // namespace simgap
