#include "derived_motion.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/core/units.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/measure/logs/resolution.h"
#include "turns.h"

namespace simgap {
namespace {

/// Standard deviation of a velocity that was worked out from positions of noise sigma, sampled at f_s and smoothed with
/// gain G = 1 / (1 + (f / B)^6):  sigma_v^2 = 2 sigma^2 / f_s int_0^inf (2 pi f)^2 G^2 df = sigma^2 (2 pi B)^2 pi B /
/// (6 f_s).
double derivedNoise(const ActuatorLog& log, std::span<const Block> runs, double bandwidth) {
  double sigma = 0.0;
  for (const Block& rows : splitRows(log.session, log.rows())) {
    sigma = std::max(sigma, noiseLevel(std::span(log.position).subspan(rows.begin, rows.size())));
  }
  return sigma * 2.0 * std::numbers::pi * bandwidth *
         std::sqrt(std::numbers::pi * bandwidth / (6.0 * samplingRate(log.time, runs)));
}

/// Rows seconds apart show no drive that turns back: most often their stamps are of another unit.
void requireDenseRows(const ActuatorLog& log, const char* quantity, double rate) {
  constexpr double kLongest = 1.5;  // [s] between rows
  if (rate * kLongest > 1.0) return;
  throw DataError(
      fmt::format("{}: found rows {:.3g} s apart, expected several a second: {} has to be worked out from motion (are "
                  "these milliseconds? then the column is time_ms)",
                  log.file, 1.0 / rate, quantity));
}

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

/// What a wider smoothing keeps of the acceleration and that of `bandwidth` does not, shape (rows).
std::vector<double> lostAcceleration(const ActuatorLog& log, std::span<const Block> runs, bool of_velocity,
                                     double bandwidth) {
  constexpr double kWider = 2.0;
  const std::vector<double>& measured = of_velocity ? log.velocity : log.position;
  std::vector<double> lost = smoothMotion(log.time, measured, of_velocity, runs, kWider * bandwidth).acceleration;
  const std::vector<double> kept = smoothMotion(log.time, measured, of_velocity, runs, bandwidth).acceleration;
  for (std::size_t i = 0; i < lost.size(); ++i) lost[i] -= kept[i];
  return lost;
}

}  // namespace

bool isTooShort(const Block& run) { return run.size() < kFewestInARow; }

SmoothMotion smoothMotion(std::span<const double> time, std::span<const double> measured, bool of_velocity,
                          std::span<const Block> runs, double bandwidth) {
  SmoothMotion motion{std::vector<double>(measured.size(), 0.0), std::vector<double>(measured.size(), 0.0)};
  for (const Block& run : runs) {
    if (isTooShort(run)) continue;
    const std::span<const double> times = time.subspan(run.begin, run.size());
    std::vector<double> speed = smooth(times, measured.subspan(run.begin, run.size()), bandwidth);
    if (!of_velocity) speed = differentiate(times, speed);
    const auto begin = static_cast<std::ptrdiff_t>(run.begin);
    std::ranges::copy(speed, motion.velocity.begin() + begin);
    std::ranges::copy(differentiate(times, speed), motion.acceleration.begin() + begin);
  }
  return motion;
}

void completeMotion(ActuatorLog& log, std::span<const Block> runs, std::optional<double> bandwidth, bool acceleration,
                    FrictionData& data) {
  const bool velocity = log.velocity.empty();
  if (!velocity && !acceleration) return;
  const char* quantity = velocity ? "velocity" : "acceleration";
  if (!log.has_time) {
    throw DataError(
        fmt::format("{}: found no time_s, expected it: {} has to be worked out from motion", log.file, quantity));
  }
  std::vector<Block> whole;
  std::ranges::remove_copy_if(runs, std::back_inserter(whole), isTooShort);
  if (whole.empty()) {
    throw DataError(fmt::format("{}: found no session of {} rows, expected one: {} has to be worked out from motion",
                                log.file, kFewestInARow, quantity));
  }
  // One derivative of a measured velocity is quieter than two of a position.
  const std::vector<double>& measured = velocity ? log.position : log.velocity;
  const double rate = samplingRate(log.time, whole), highest = FrictionDataOptions::kDefaultBandwidth * rate;
  requireDenseRows(log, quantity, rate);
  data.bandwidth = bandwidth ? *bandwidth : smoothingBandwidth(log.time, measured, whole, highest);
  SmoothMotion motion = smoothMotion(log.time, measured, !velocity, runs, data.bandwidth);
  if (velocity) log.velocity = std::move(motion.velocity);
  if (acceleration) log.acceleration = std::move(motion.acceleration);
  if (velocity) data.derived.emplace_back("velocity");
  if (acceleration) data.derived.emplace_back("acceleration");
}

void smoothLikeMotion(ActuatorLog& log, std::span<const Block> runs, const MotionSign& sign, FrictionData& data) {
  constexpr double kClear = 2.0;     // times the noise
  constexpr double kGoesWith = 0.5;  // correlation
  if (data.derived.empty()) return;
  const double friction = frictionAtTurns(log.effort, sign.direction, runs);
  std::vector<double> effort = log.effort;
  for (std::size_t i = 0; i < effort.size(); ++i) effort[i] -= friction * sign.direction[i];
  std::vector<double> smoothed = smoothRuns(log.time, effort, runs, data.bandwidth);
  const std::vector<double> lost = lostAcceleration(log, runs, data.derived.front() != "velocity", data.bandwidth);
  std::vector<double> faster, accelerates;  // rows that count
  for (std::size_t i = 0; i < effort.size(); ++i) {
    if (sign.keep[i]) faster.push_back(effort[i] - smoothed[i]), accelerates.push_back(lost[i]);
    smoothed[i] += friction * sign.direction[i];
  }
  const double beyond = Eigen::Map<const Eigen::VectorXd>(faster.data(), std::ssize(faster)).norm() /
                        std::sqrt(std::max(1.0, static_cast<double>(faster.size())));
  if (getenv("DBG"))
    fprintf(stderr, "beyond %g noise %g corr %g B %g\n", beyond, noiseLevel(log.effort),
            correlation(faster, accelerates), data.bandwidth);
  if (!(beyond > kClear * noiseLevel(log.effort)) || std::abs(correlation(faster, accelerates)) < kGoesWith) return;
  data.warnings.push_back(
      fmt::format("{} was smoothed like the motion: it accelerates faster than what was worked out "
                  "can follow, by {:.2g} {}",
                  quantityName(log.effort_name, log.effort_unit), beyond, log.effort_unit));
  log.effort = std::move(smoothed);
  if (log.load.empty()) return;
  const std::vector<double> load = smoothRuns(log.time, log.load, runs, data.bandwidth);
  for (std::size_t i = 0; i < load.size(); ++i) data.load[static_cast<Eigen::Index>(i)] += load[i] - log.load[i];
}

double derivedDeadBand(const ActuatorLog& log, std::span<const Block> runs, double bandwidth, double widths) {
  // One count of an encoder, smoothed, is a velocity of count times the peak of the smoother's answer to a step:
  // 2 int_0^inf G df = 2 pi B / 3. A drive at rest may stand between two counts.
  const double count = quantumOf(log.position) * 2.0 * std::numbers::pi * bandwidth / 3.0;
  return std::max(widths * std::max(noiseLevel(log.velocity), derivedNoise(log, runs, bandwidth)), count);
}

}  // namespace simgap
