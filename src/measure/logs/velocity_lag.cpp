#include "simgap/measure/logs/velocity_lag.h"

#include <algorithm>
#include <cmath>

#include "simgap/core/statistics.h"
#include "simgap/measure/logs/friction_rows.h"
#include "simgap/measure/logs/motion.h"

namespace simgap {
namespace {

constexpr int kMostLag = 12;            // of lag
constexpr std::size_t kRowsOfRun = 50;  // of a run
constexpr double kQuick = 0.75;         // quantile of speeds, and of their changes: rests may be half of a log
constexpr double kFollows = 0.25;       // of that speed, squared: a velocity that differs by more is another one
constexpr double kClearlyNearer = 2.0;  // times what they do not share
constexpr double kNoLag = 0.2;          // rows: less is what rounding and jitter make

struct Speeds {
  std::vector<double> slope, velocity;  ///< of one run, smoothed alike
};

std::vector<Speeds> smoothedAlike(std::span<const double> time, std::span<const double> position,
                                  std::span<const double> velocity, std::span<const Block> runs) {
  const double bandwidth =
      smoothingBandwidth(time, position, runs, FrictionDataOptions::kDefaultBandwidth * samplingRate(time, runs));
  std::vector<Speeds> all;
  for (const Block& run : runs) {
    if (run.size() < kRowsOfRun) continue;
    const auto own = [&](std::span<const double> values) { return values.subspan(run.begin, run.size()); };
    all.push_back({differentiate(own(time), smooth(own(time), own(position), bandwidth)),
                   smooth(own(time), own(velocity), bandwidth)});
  }
  return all;
}

/// By how much speed changes from the row before to the row after; 0 at the ends of a run.
double changeAt(const Speeds& run, std::size_t row) {
  return row > 0 && row + 1 < run.slope.size() ? std::abs(run.slope[row + 1] - run.slope[row - 1]) : 0.0;
}

/// Variance of the slope less the velocity some rows later, in the rows in which speed changes most: at an even speed
/// none is late. A few spikes do not count.
/// \param bend  [rad/s] that it changes by at least
double apart(const std::vector<Speeds>& speeds, int rows, double bend) {
  std::vector<double> differences;
  const auto late = static_cast<std::ptrdiff_t>(rows);
  for (const Speeds& run : speeds) {
    const auto n = std::ssize(run.slope);
    for (std::ptrdiff_t i = std::max<std::ptrdiff_t>(0, -late); i < std::min(n, n - late); ++i) {
      if (changeAt(run, i) >= bend) differences.push_back(run.slope[i] - run.velocity[i + late]);
    }
  }
  const double sd = robustDeviation(std::move(differences));
  return sd * sd;
}

/// Of all rows that quantile of a speed, or of its changes.
template <typename Of>
double quickest(const std::vector<Speeds>& speeds, Of of) {
  std::vector<double> sizes;
  for (const Speeds& run : speeds) {
    for (std::size_t i = 0; i < run.slope.size(); ++i) sizes.push_back(of(run, i));
  }
  return quantile(std::move(sizes), kQuick);
}

}  // namespace

std::optional<double> velocityLag(std::span<const double> time, std::span<const double> position,
                                  std::span<const double> velocity, std::span<const Block> runs) {
  const std::vector<Speeds> speeds = smoothedAlike(time, position, velocity, runs);
  if (speeds.empty()) return std::nullopt;
  const double fast = quickest(speeds, [](const Speeds& run, std::size_t row) { return std::abs(run.slope[row]); });
  const double bend = quickest(speeds, changeAt);
  std::vector<double> at;
  for (int rows = -kMostLag; rows <= kMostLag; ++rows) at.push_back(apart(speeds, rows, bend));
  const auto best = std::ranges::min_element(at) - at.begin();
  if (best == 0 || best == 2 * kMostLag || at[best] > kFollows * fast * fast) return std::nullopt;
  // The vertex of the parabola through the three lowest.
  const double left = at[best - 1], middle = at[best], right = at[best + 1];
  const double part = 0.5 * (left - right) / std::max(left - 2.0 * middle + right, 1e-300);
  const double lowest = middle - 0.25 * (left - right) * part;
  const double rows = static_cast<double>(best - kMostLag) + part;
  if (std::abs(rows) < kNoLag || at[kMostLag] < kClearlyNearer * std::max(lowest, 0.0)) return std::nullopt;
  return rows / samplingRate(time, runs);
}

std::vector<double> moved(std::span<const double> time, std::span<const double> values, std::span<const Block> runs,
                          double lag) {
  std::vector<double> result(values.begin(), values.end());
  for (const Block& run : runs) {
    std::size_t k = run.begin;
    for (std::size_t i = run.begin; i < run.end; ++i) {
      const double wanted = std::clamp(time[i] + lag, time[run.begin], time[run.end - 1]);
      while (k > run.begin && time[k] > wanted) --k;
      while (k + 2 < run.end && time[k + 1] < wanted) ++k;
      if (k + 1 >= run.end) continue;
      const double part = (wanted - time[k]) / (time[k + 1] - time[k]);
      result[i] = (1.0 - part) * values[k] + part * values[k + 1];
    }
  }
  return result;
}

}  // namespace simgap
