#include "parallel_filter.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "channel_difference.h"
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
  const auto acceleration = [&](double bandwidth) {
    return smoothMotion(log.time, measured, of_velocity, runs, bandwidth).acceleration;
  };
  return difference(acceleration(kWider * data.bandwidth), acceleration(data.bandwidth));
}

std::vector<double> kept(const std::vector<double>& values, const std::vector<bool>& keep) {
  std::vector<double> some;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (keep[i]) some.push_back(values[i]);
  }
  return some;
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
  const std::vector<double> fast = kept(difference(effort, smoothed), sign.keep);
  const double size =
      std::sqrt(std::inner_product(fast.begin(), fast.end(), fast.begin(), 0.0) / static_cast<double>(fast.size()));
  if (!(size > kClear * noiseLevel(log.effort))) return;
  if (!(std::abs(correlation(fast, kept(lostAcceleration(log, runs, data), sign.keep))) >= kGoesWith)) return;
  data.warnings.push_back(
      fmt::format("{} was smoothed like the motion, {:.3g} Hz: it accelerates faster than what was "
                  "worked out can follow, by {:.2g} {}",
                  quantityName(log.effort_name, log.effort_unit), data.bandwidth, size, log.effort_unit));
  for (std::size_t i = 0; i < effort.size(); ++i) log.effort[i] = smoothed[i] + friction * sign.direction[i];
  if (log.load.empty()) return;
  const std::vector<double> change = difference(smoothRuns(log.time, log.load, runs, data.bandwidth), log.load);
  data.load += Eigen::Map<const Eigen::ArrayXd>(change.data(), std::ssize(change));
}

}  // namespace simgap
