#include "simgap/measure/logs/stamps.h"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "simgap/core/statistics.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/measure/logs/resolution.h"

namespace simgap {
namespace {

constexpr std::size_t kBesideRow = 5;         // rows on either side whose median says where the grid lies
constexpr std::size_t kRowsWithoutLoss = 24;  // of a stretch without a lost sample
constexpr double kClockDrift = 1.0 / 60.0;    // periods per row: what is slower is the clock's, not a stamp's
constexpr double kRounding = 0.9;             // counts: the median size of the third difference of what is rounded off
constexpr double kClearlySmoother = 2.0;      // times, to believe the rows rather than the stamps

/// How late each stamp is against rows that lie `step` apart.
std::vector<double> offsets(std::span<const double> time, double step) {
  std::vector<double> offset(time.size());
  for (std::size_t i = 0; i < time.size(); ++i) offset[i] = time[i] - time[0] - static_cast<double>(i) * step;
  return offset;
}

/// Where samples were lost the offset rises by whole steps, and stays there.
std::vector<std::size_t> stretchEnds(std::span<const double> offset, double step) {
  const auto level = [&](std::size_t from) {
    return upperMedian(std::vector<double>(offset.begin() + static_cast<std::ptrdiff_t>(from),
                                           offset.begin() + static_cast<std::ptrdiff_t>(from + kBesideRow)));
  };
  const auto rise = [&](std::size_t i) { return offset[i] - offset[i - 1]; };
  std::vector<std::size_t> ends;
  bool inside = false;
  for (std::size_t i = kBesideRow; i + kBesideRow <= offset.size(); ++i) {
    const bool was_inside = inside;
    inside = std::abs(level(i) - level(i - kBesideRow)) > 0.5 * step;
    if (!inside) continue;
    if (!was_inside) {
      ends.push_back(i);
    } else if (rise(i) > rise(ends.back())) {
      ends.back() = i;
    }
  }
  ends.push_back(offset.size());
  return ends;
}

/// Even times of one run; the stamps where there are too few rows.
void fillRun(std::span<const double> time, std::span<double> even) {
  std::ranges::copy(time, even.begin());
  if (time.size() < kRowsWithoutLoss) return;
  const double step = usualStep(time);
  const std::vector<double> offset = offsets(time, step);
  std::size_t begin = 0;
  for (const std::size_t end : stretchEnds(offset, step)) {
    const std::size_t rows = end - begin;
    if (rows >= kRowsWithoutLoss) {
      std::vector<double> row(rows);
      std::iota(row.begin(), row.end(), 0.0);
      const std::vector<double> drift = smooth(row, std::span(offset).subspan(begin, rows), kClockDrift);
      for (std::size_t k = 0; k < rows; ++k)
        even[begin + k] = time[0] + static_cast<double>(begin + k) * step + drift[k];
    }
    begin = end;
  }
}

/// x(t) over four rows against the parabola that three of them would allow: the third divided difference, scaled to
/// (-1, 3, -3, 1) for even steps.
double thirdDifferenceAt(std::span<const double> time, std::span<const double> values, std::size_t i) {
  const double step = (time[i + 3] - time[i]) / 3.0;
  double sum = 0.0;
  for (std::size_t k = i; k < i + 4; ++k) {
    double weight = 6.0;
    for (std::size_t j = i; j < i + 4; ++j) {
      if (j != k) weight *= step / (time[k] - time[j]);
    }
    sum += weight * values[k];
  }
  return sum;
}

/// Median size of third differences where the channel moves fast, over the stamps and over even times.
std::pair<double, double> roughness(std::span<const double> time, std::span<const double> even,
                                    std::span<const double> values, std::span<const Block> runs) {
  std::vector<double> travel;
  std::vector<std::size_t> at;
  for (const Block& run : runs) {
    for (std::size_t i = run.begin; i + 3 < run.end; ++i) {
      at.push_back(i);
      travel.push_back(std::abs(values[i + 3] - values[i]));
    }
  }
  if (at.empty()) return {0.0, 0.0};
  const double fast = quantile(travel, 0.75);
  std::vector<double> stamped, evenly;
  for (std::size_t k = 0; k < at.size(); ++k) {
    if (travel[k] < fast) continue;
    stamped.push_back(std::abs(thirdDifferenceAt(time, values, at[k])));
    evenly.push_back(std::abs(thirdDifferenceAt(even, values, at[k])));
  }
  return {upperMedian(std::move(stamped)), upperMedian(std::move(evenly))};
}

}  // namespace

double usualStep(std::span<const double> time) {
  if (time.size() < 2) return 0.0;
  std::vector<double> steps(time.size() - 1);
  for (std::size_t i = 0; i < steps.size(); ++i) steps[i] = time[i + 1] - time[i];
  return upperMedian(std::move(steps));
}

std::optional<EvenTimes> evenTimes(std::span<const double> time, std::span<const double> values,
                                   std::span<const Block> runs) {
  EvenTimes result;
  result.time.assign(time.begin(), time.end());
  std::vector<double> late;
  for (const Block& run : runs) {
    const std::span<double> even = std::span(result.time).subspan(run.begin, run.size());
    fillRun(time.subspan(run.begin, run.size()), even);
    if (!std::is_sorted(even.begin(), even.end(), std::less_equal<>())) return std::nullopt;
    for (std::size_t i = run.begin; i < run.end; ++i) late.push_back(time[i] - result.time[i]);
  }
  auto [stamped, evenly] = roughness(time, result.time, values, runs);
  evenly = std::max(evenly, kRounding * quantumOf(values));
  if (!(stamped > kClearlySmoother * evenly)) return std::nullopt;
  result.jitter = robustDeviation(std::move(late));
  result.times_smoother = stamped / std::max(evenly, 1e-300);
  return result;
}

}  // namespace simgap
