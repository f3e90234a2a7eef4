#include "parallel_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "derived_motion.h"
#include "simgap/core/statistics.h"
#include "simgap/core/units.h"
#include "simgap/measure/logs/resolution.h"
#include "turns.h"

namespace simgap {
namespace {

/// Half of what an effort changes by where a drive turns, two rows before it to two behind. What accelerates it is at
/// its largest there and changes little.
double frictionAtTurns(std::span<const double> effort, std::span<const signed char> direction,
                       std::span<const Block> runs) {
  constexpr std::size_t kBeside = 2;
  std::vector<double> jumps;
  for (const std::size_t turn : turnsOf(direction, runs)) {
    if (turn < kBeside + 1 || turn + kBeside >= effort.size()) continue;
    jumps.push_back(0.5 * direction[turn] * (effort[turn + kBeside] - effort[turn - 1 - kBeside]));
  }
  return jumps.empty() ? 0.0 : std::max(0.0, upperMedian(std::move(jumps)));
}

/// What a wider smoothing keeps of the acceleration and the one that was worked out does not, shape (rows).
std::vector<double> lostAcceleration(const ActuatorLog& log, std::span<const Block> runs, const FrictionData& data) {
  constexpr double kWider = 2.0;
  const bool of_velocity = data.derived.front() != "velocity";
  const std::vector<double>& measured = of_velocity ? log.velocity : log.position;
  std::vector<double> lost = smoothMotion(log.time, measured, of_velocity, runs, kWider * data.bandwidth).acceleration;
  const std::vector<double> kept = smoothMotion(log.time, measured, of_velocity, runs, data.bandwidth).acceleration;
  for (std::size_t i = 0; i < lost.size(); ++i) lost[i] -= kept[i];
  return lost;
}

/// Root mean square over the rows that count of what an effort changes by faster than the motion can follow, and how
/// that goes with the acceleration which the motion lost.
struct FastEffort {
  double size, goes_with;
};

FastEffort fastEffort(std::span<const double> effort, std::span<const double> smoothed, std::span<const double> lost,
                      const std::vector<bool>& keep) {
  std::vector<double> fast, accelerates;
  double squares = 0.0;
  for (std::size_t i = 0; i < keep.size(); ++i) {
    if (!keep[i]) continue;
    fast.push_back(effort[i] - smoothed[i]);
    accelerates.push_back(lost[i]);
    squares += fast.back() * fast.back();
  }
  if (fast.empty()) return {0.0, 0.0};
  return {std::sqrt(squares / static_cast<double>(fast.size())), std::abs(correlation(fast, accelerates))};
}

}  // namespace

void smoothLikeMotion(ActuatorLog& log, std::span<const Block> runs, const MotionSign& sign, FrictionData& data) {
  constexpr double kClear = 3.0;     // times the noise
  constexpr double kGoesWith = 0.5;  // correlation
  if (data.derived.empty()) return;
  const double friction = frictionAtTurns(log.effort, sign.direction, runs);
  std::vector<double> effort = log.effort;
  for (std::size_t i = 0; i < effort.size(); ++i) effort[i] -= friction * sign.direction[i];
  std::vector<double> smoothed = smoothRuns(log.time, effort, runs, data.bandwidth);
  const FastEffort fast = fastEffort(effort, smoothed, lostAcceleration(log, runs, data), sign.keep);
  if (fast.size <= kClear * noiseLevel(log.effort) || !(fast.goes_with >= kGoesWith)) return;
  data.warnings.push_back(
      fmt::format("{} was smoothed like the motion, {:.3g} Hz: it accelerates faster than what was "
                  "worked out can follow, by {:.2g} {}",
                  quantityName(log.effort_name, log.effort_unit), data.bandwidth, fast.size, log.effort_unit));
  for (std::size_t i = 0; i < effort.size(); ++i) log.effort[i] = smoothed[i] + friction * sign.direction[i];
  if (log.load.empty()) return;
  const std::vector<double> load = smoothRuns(log.time, log.load, runs, data.bandwidth);
  for (std::size_t i = 0; i < load.size(); ++i) data.load[static_cast<Eigen::Index>(i)] += load[i] - log.load[i];
}

}  // namespace simgap
