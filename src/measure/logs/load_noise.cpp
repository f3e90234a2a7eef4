#include "load_noise.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>
#include <vector>

#include "channel_difference.h"
#include "simgap/core/statistics.h"
#include "simgap/measure/logs/motion.h"

namespace simgap {
namespace {

/// Correlation of the signs of what no joint does, the fast half of what rows can show: a few jerks do not decide it.
double answer(const ActuatorLog& log, std::span<const Block> runs, double rate) {
  const auto signs = [&](const std::vector<double>& channel) {
    std::vector<double> fast = difference(channel, smoothRuns(log.time, channel, runs, 0.25 * rate));
    for (double& value : fast) value = static_cast<double>(value > 0.0) - static_cast<double>(value < 0.0);
    return fast;
  };
  return std::abs(correlation(signs(log.load), signs(log.effort)));
}

}  // namespace

void smoothNoisyLoad(ActuatorLog& log, std::span<const Block> runs, FrictionData& data) {
  constexpr double kBends = 1e-3;    // of the load's variance: as much is k_a off
  constexpr double kAnswers = 0.15;  // correlation of the effort with noise that a controller, or the drive, feels
  constexpr double kSame = 1e-9;     // of its size: what it varies by is round-off
  constexpr double kNothing = 1.5;   // times what smoothing leaves of white noise: no load acts
  if (!log.has_time || log.load.empty()) return;
  const double rate = samplingRate(log.time, runs);
  const double bandwidth = smoothingBandwidth(log.time, log.load, runs, 0.5 * rate);
  std::vector<double> load = smoothRuns(log.time, log.load, runs, bandwidth);
  const std::vector<double> noise = difference(log.load, load);
  const double sd = robustDeviation(noise), spread = standardDeviation(load);
  if (spread <= kSame * std::abs(load.front())) return;
  const double left = sd * std::sqrt(2.0 * bandwidth / rate);
  if (sd * sd <= kBends * spread * spread || spread < kNothing * left) return;
  if (answer(log, runs, rate) > kAnswers) return;
  log.load = std::move(load);
  data.load_noise = std::pow(left / spread, 2);
  data.warnings.push_back(
      fmt::format("{} is noisy (sd {:.2g} {} of {:.2g}): it was smoothed to {:.2g} Hz, or k_a would come out too large",
                  log.linear ? "external_force" : "external_torque", sd, log.loadUnit(), spread, bandwidth));
}

}  // namespace simgap
