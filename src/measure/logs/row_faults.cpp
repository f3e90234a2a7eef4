#include "row_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <span>
#include <utility>

#include "derived_motion.h"
#include "prepared_rows.h"
#include "simgap/core/blocks.h"
#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/measure/logs/channel_checks.h"
#include "simgap/measure/logs/resolution.h"
#include "simgap/measure/logs/rests.h"
#include "simgap/measure/logs/spikes.h"
#include "simgap/measure/logs/stamps.h"
#include "simgap/measure/logs/velocity_lag.h"

namespace simgap {

void takeEvenTimes(ActuatorLog& log, std::span<const Block> runs, bool acceleration, FrictionData& data) {
  const bool from_position = !log.position.empty();
  if (!log.has_time || (!log.velocity.empty() && !acceleration)) return;
  std::optional<EvenTimes> even = evenTimes(log.time, from_position ? log.position : log.velocity, runs);
  if (!even) return;
  data.warnings.push_back(fmt::format(
      "time_s jitters by {:.2g} ms and the samples do not: over even times the {} is {:.1f} times smoother, and these "
      "were taken",
      1e3 * even->jitter, from_position ? "position" : "velocity", even->times_smoother));
  log.time = std::move(even->time);
}

void moveLateVelocity(ActuatorLog& log, std::span<const Block> runs, FrictionData& data) {
  if (!log.has_time || log.velocity.empty() || log.position.empty()) return;
  const std::optional<double> lag = velocityLag(log.time, log.position, log.velocity, runs);
  if (!lag) return;
  data.warnings.push_back(fmt::format(
      "motor_velocity comes {:.3g} ms {} than the slope of the position: it was moved by that, and delays count from "
      "the position",
      1e3 * std::abs(*lag), *lag > 0.0 ? "later" : "earlier"));
  log.velocity = moved(log.time, log.velocity, runs, *lag);
}

namespace {

/// As noiseLevel(), but from third differences, which a fast motion at few rows a second bends less.
double noiseBesideMotion(std::span<const double> values) {
  std::vector<double> thirds;
  for (std::size_t i = 3; i < values.size(); ++i) {
    thirds.push_back(values[i] - 3.0 * values[i - 1] + 3.0 * values[i - 2] - values[i - 3]);
  }
  if (thirds.empty()) return 0.0;
  // The variance of a third difference of white noise is 1 + 9 + 9 + 1 times the noise's.
  return std::max(robustDeviation(std::move(thirds)) / std::sqrt(20.0), quantumOf(values) / 4.0);
}

}  // namespace

void replaceNoisyVelocity(ActuatorLog& log, std::span<const Block> runs, FrictionData& data) {
  constexpr double kNoisier = 3.0;
  if (!log.has_time || log.velocity.empty() || log.position.empty()) return;
  const double noise = noiseBesideMotion(log.velocity);
  const double of_slope = noiseBesideMotion(log.position) * samplingRate(log.time, runs) / std::numbers::sqrt2;
  if (of_slope == 0.0 || noise <= kNoisier * of_slope) return;
  std::vector<double> differences;
  for (const Block& run : runs) {
    for (std::size_t i = run.begin + 1; i + 1 < run.end; ++i) {
      const double slope = (log.position[i + 1] - log.position[i - 1]) / (log.time[i + 1] - log.time[i - 1]);
      differences.push_back(log.velocity[i] - slope);
    }
  }
  if (differences.empty() || robustDeviation(std::move(differences)) > kNoisier * noise) return;  // of another shaft
  data.warnings.push_back(
      fmt::format("motor_velocity is {:.2g} times as noisy as the slope of the position, which says the same: it was "
                  "worked out from the position",
                  noise / of_slope));
  log.velocity.clear();
}

void putSpikesRight(ActuatorLog& log, FrictionData& data) {
  if (!log.has_time) return;
  const std::string effort = quantityName(log.effort_name, log.effort_unit);
  const SearchedChannel channels[] = {{"motor_position", &log.position, kMotionSpikes},
                                      {"motor_velocity", &log.velocity, kMotionSpikes},
                                      {effort, &log.effort, kEffortSpikes},
                                      {log.linear ? "external_force" : "external_torque", &log.load, kEffortSpikes}};
  data.spikes = repairSpikes(log.time, log.session, channels);
}

void leaveOutSpikes(const FrictionDataOptions& options, MotionSign& sign, FrictionData& data) {
  leaveOutRows(data.spikes, sign.keep);
  if (options.all_rows) return;  // whoever asked for all rows says it himself
  for (const ChannelSpikes& spikes : data.spikes) {
    data.warnings.push_back(
        fmt::format("{} (the first is row {}): they are left out", standsAlone(spikes), spikes.rows.front() + 1));
  }
}

void leaveOutShortRuns(std::span<const Block> runs, MotionSign& sign, FrictionData& data) {
  std::size_t rows = 0;
  for (const Block& run : runs) {
    if (data.derived.empty() || !isTooShort(run)) continue;
    std::fill(sign.keep.begin() + static_cast<std::ptrdiff_t>(run.begin),
              sign.keep.begin() + static_cast<std::ptrdiff_t>(run.end), false);
    rows += run.size();
  }
  if (rows == 0) return;
  data.warnings.push_back(
      fmt::format("{} rows are of sessions or between gaps with fewer than {}: too few for a {}, they are left out",
                  rows, kFewestInARow, data.derived.front()));
}

void leaveOutRests(const ActuatorLog& log, double blurred_seconds, bool sticks_shortly,
                   const FrictionDataOptions& options, MotionSign& sign, FrictionData& data) {
  constexpr std::ptrdiff_t kFewestRows = 50;  // of motion
  if (options.raw_sign || !log.has_time) return;
  RestRule rule{restingSpeed(log.velocity, sign.dead_band)};
  rule.blurred_seconds = blurred_seconds;
  if (sticks_shortly) {
    rule.least_seconds = 0.0;
    rule.fewest_rows = 2;
  }
  const auto movingRows = [&](const RestRule& by) {
    const std::vector<bool> rest = findRests(log.time, log.velocity, log.session, by);
    std::vector<bool> moving = sign.keep;
    for (std::size_t i = 0; i < rest.size(); ++i) moving[i] = moving[i] && !rest[i];
    return moving;
  };
  std::vector<bool> moving = movingRows(rule);
  const auto counted = std::ranges::count(sign.keep, true), left = std::ranges::count(moving, true);
  if (left == counted) return;
  if (left >= kFewestRows) {
    std::ptrdiff_t beside = 0;
    if (blurred_seconds > 0.0) {
      rule.blurred_seconds = 0.0;
      beside = std::ranges::count(movingRows(rule), true) - left;
    }
    const auto still = counted - left - beside;
    sign.keep = std::move(moving);
    data.warnings.push_back(fmt::format(
        "the drive stands still in {} rows ({:.1f} %){}: they are left out, because a held drive's effort may lie "
        "anywhere within its static friction",
        still, 100.0 * static_cast<double>(still) / static_cast<double>(log.rows()),
        beside > 0 ? fmt::format(", and {} are beside these, where smoothed motion is blurred", beside) : ""));
    return;
  }
  const std::string found = fmt::format("the drive moves in {} of {} rows", left, log.rows());
  if (options.all_rows) {
    throw DataError(
        fmt::format("{}: {}, expected at least {}: no cause can be told from what holds it; record motion in "
                    "both directions",
                    log.file, found, kFewestRows));
  }
  data.warnings.push_back(found + ": its rests were fitted, too, and a held drive's effort is no friction in motion");
}

void leaveOutSwitchedOff(const ActuatorLog& log, const FrictionDataOptions& options, MotionSign& sign,
                         FrictionData& data) {
  constexpr double kMoves = 2.0;              // dead bands
  constexpr std::ptrdiff_t kFewestLeft = 50;  // rows of motion
  if (options.raw_sign || !log.has_time || log.effort_unit != "V") return;
  std::vector<bool> driven = sign.keep;
  for (const Block& run : switchedOff(log.time, log.session, log.effort, log.velocity, kMoves * sign.dead_band)) {
    std::fill(driven.begin() + run.begin, driven.begin() + run.end, false);
  }
  const auto off = std::ranges::count(sign.keep, true) - std::ranges::count(driven, true);
  if (off == 0 || std::ranges::count(driven, true) < kFewestLeft) return;
  sign.keep = std::move(driven);
  data.warnings.push_back(
      fmt::format("{} is exactly 0 in {} rows of motion ({:.1f} %), for 0.2 s and longer: they are left out, because a "
                  "motor that is switched off has open terminals, and 0 is not their voltage",
                  quantityName(log.effort_name, log.effort_unit), off,
                  100.0 * static_cast<double>(off) / static_cast<double>(log.rows())));
}

}  // namespace simgap
