#include "simgap/measure/logs/channel_checks.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/measure/logs/resolution.h"

namespace simgap {
namespace {

/// Share of rows in runs of at least `least` rows that stand exactly on `value`.
double shareAt(std::span<const double> values, double value, std::size_t least) {
  std::size_t count = 0;
  for (const Block& run : runsAt(values, value)) count += run.size() >= least ? run.size() : 0;
  return static_cast<double>(count) / static_cast<double>(values.size());
}

struct Run {
  std::size_t begin = 0;
  std::size_t size = 0;
};

Run longestRun(std::span<const double> values) {
  Run longest, run;
  for (std::size_t i = 0; i < values.size(); ++i) {
    run = i > 0 && values[i] == values[i - 1] ? Run{run.begin, run.size + 1} : Run{i, 1};
    if (run.size > longest.size) longest = run;
  }
  return longest;
}

}  // namespace

bool isConstant(std::span<const double> values) {
  return std::ranges::all_of(values, [&](double value) { return value == values.front(); });
}

std::size_t differentValues(std::span<const double> values, std::size_t most) {
  std::set<double> seen;
  for (const double value : values) {
    seen.insert(value);
    if (seen.size() > most) break;
  }
  return seen.size();
}

void requireMoreThanSteps(const std::string& file, const std::string& name, std::span<const double> values) {
  const std::size_t different = differentValues(values, kMostSteps);
  if (different > kMostSteps) return;
  throw DataError(
      fmt::format("{}: {} takes {} different values in all rows that count, expected more than {}: a command of steps, "
                  "which an offset and friction meet exactly, whatever acts; record what the motor draws, or commands "
                  "that vary (ramps, sines)",
                  file, name, different, kMostSteps));
}

std::vector<Block> switchedOff(std::span<const double> time, std::span<const int> session,
                               std::span<const double> voltage, std::span<const double> velocity, double slow) {
  constexpr double kLeast = 0.2;       // [s] of exactly nothing: a controller only passes zero
  constexpr std::size_t kFewest = 10;  // rows of it
  std::vector<Block> runs;
  for (std::size_t begin = 0, end = 0; begin < time.size(); begin = std::max(end, begin + 1)) {
    bool moves = false;
    for (end = begin; end < time.size() && session[end] == session[begin] && voltage[end] == 0.0; ++end) {
      moves = moves || std::abs(velocity[end]) > slow;
    }
    if (moves && end - begin >= kFewest && time[end - 1] - time[begin] >= kLeast) runs.push_back({begin, end});
  }
  return runs;
}

void requireMotion(const std::string& file, const std::string& name, std::span<const double> values,
                   std::span<const double> driven) {
  constexpr double kSpread = 8.0;   // noise levels: more than the whole range of a rest
  constexpr double kFollows = 0.1;  // correlation: rows may be levels in any order, whose neighbours differ by much
  if (isConstant(values)) {
    throw DataError(fmt::format("{}: {} is constant throughout: nothing can be found from it", file, name));
  }
  const std::vector<double> all(values.begin(), values.end());
  const double spread = quantile(all, 0.995) - quantile(all, 0.005), noise = noiseLevel(values);
  if (spread > kSpread * noise || isConstant(driven) || std::abs(correlation(values, driven)) > kFollows) return;
  throw DataError(
      fmt::format("{}: {} stays within its own noise (it spreads by {:.2g}, noise {:.2g}): nothing can be "
                  "found from rests alone; record motion",
                  file, name, spread, noise));
}

std::vector<std::string> checkChannels(const std::string& file, std::span<const ChannelCheck> channels) {
  constexpr double kClippedShare = 0.005;
  constexpr std::size_t kClippedRun = 3;
  constexpr double kStuckShare = 0.05;
  constexpr std::size_t kStuckRows = 50;
  std::vector<std::string> warnings;
  for (const auto& [name, values, plausible] : channels) {
    if (values.empty()) continue;
    const auto [low, high] = std::ranges::minmax(values);
    const double largest = std::max(std::abs(low), std::abs(high));
    if (largest > plausible) {
      throw DataError(
          fmt::format("{}: {} reaches {:.4g}, expected at most {:.4g}: is the unit in the column's name "
                      "right? (--map gives a column another name)",
                      file, name, largest, plausible));
    }
    if (low == high) continue;  // said by whoever needs the channel
    if (differentValues(values, kMostSteps) <= kMostSteps) continue;
    for (const auto& [bound, side] : {std::pair{high, "above"}, std::pair{low, "below"}}) {
      const double share = bound == 0.0 ? 0.0 : shareAt(values, bound, kClippedRun);
      if (share < kClippedShare || comesByCounts(values, bound, kClippedRun)) continue;
      warnings.push_back(
          fmt::format("{} stands at {:.4g} in {:.1f} % of the rows, nothing is {}: it looks clipped, which "
                      "biases every parameter; leave these rows out or record with a larger range",
                      name, bound, 100.0 * share, side));
    }
    const Run run = longestRun(values);
    if (run.size >= kStuckRows && static_cast<double>(run.size) > kStuckShare * static_cast<double>(values.size()) &&
        values[run.begin] != 0.0 && values[run.begin] != high && values[run.begin] != low) {
      warnings.push_back(
          fmt::format("{} keeps the value {:.4g} for {} rows from row {}: it looks stuck; leave these "
                      "rows out",
                      name, values[run.begin], run.size, run.begin + 1));
    }
  }
  return warnings;
}

}  // namespace simgap
