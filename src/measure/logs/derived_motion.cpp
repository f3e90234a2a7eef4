#include "derived_motion.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numbers>

#include "simgap/core/error.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/measure/logs/resolution.h"

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

double derivedDeadBand(const ActuatorLog& log, std::span<const Block> runs, double bandwidth, double widths) {
  // One count of an encoder, smoothed, is a velocity of count times the peak of the smoother's answer to a step:
  // 2 int_0^inf G df = 2 pi B / 3. A drive at rest may stand between two counts.
  const double count = quantumOf(log.position) * 2.0 * std::numbers::pi * bandwidth / 3.0;
  return std::max(widths * std::max(noiseLevel(log.velocity), derivedNoise(log, runs, bandwidth)), count);
}

}  // namespace simgap
