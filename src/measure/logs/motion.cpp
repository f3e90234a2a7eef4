#include "simgap/measure/logs/motion.h"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "simgap/core/statistics.h"
#include "simgap/measure/logs/resolution.h"

namespace simgap {
namespace {

/// The first row of the new direction: the turning point of travel, looked for backwards from the first row clearly on
/// the new side, `to`. It ends where the noise of a rest would take the travel back (CUSUM: Page 1954).
std::size_t turningPoint(std::span<const double> velocity, std::size_t from, std::size_t to, int direction,
                         double dead_band) {
  double travel = 0.0, farthest = 0.0;
  std::size_t turn = to;
  for (std::size_t i = to; i-- > from + 1 && farthest - travel <= dead_band;) {
    travel += direction * velocity[i] - dead_band / 3.0;  // in a rest this sum falls
    if (travel <= farthest) continue;
    farthest = travel;
    turn = i;
  }
  return turn;
}

/// Third divided difference over the four uneven steps from row i, scaled to (-1, 3, -3, 1) for even ones.
Eigen::Vector4d thirdDifference(std::span<const double> time, std::size_t i, double mean_step) {
  Eigen::Vector4d row = Eigen::Vector4d::Constant(6.0);
  for (int k = 0; k < 4; ++k) {
    for (int j = 0; j < 4; ++j) {
      if (j != k) row[k] *= mean_step / (time[i + k] - time[i + j]);
    }
  }
  // Rows that come in bursts are nearly one: their differences would outweigh all others by more than digits there are.
  constexpr double kSteepest = 100.0;  // of even steps: sqrt(20)
  return row * std::min(1.0, kSteepest / row.norm());
}

/// No step of five rows is twice another: over uneven ones a polynomial swings.
bool hasEvenSteps(std::span<const double> time) {
  double shortest = time[1] - time[0], longest = shortest;
  for (std::size_t i = 1; i < 4; ++i) {
    shortest = std::min(shortest, time[i + 1] - time[i]);
    longest = std::max(longest, time[i + 1] - time[i]);
  }
  return longest < 2.0 * shortest;
}

/// Slope in the middle of the polynomial through five rows (Lagrange's). Of a sine that turns by x [rad] per row it is
/// x^4 / 30 too small, where the secant of both neighbours is x^2 / 6: 0.1 and 3 % of 7 Hz at 100 rows a second.
double slopeOfFive(std::span<const double> time, std::span<const double> values) {
  constexpr std::size_t kMiddle = 2;
  double slope = 0.0;
  for (std::size_t j = 0; j < 5; ++j) {
    if (j == kMiddle) continue;
    double weight = 1.0 / (time[j] - time[kMiddle]);
    for (std::size_t k = 0; k < 5; ++k) {
      if (k != j && k != kMiddle) weight *= (time[kMiddle] - time[k]) / (time[j] - time[k]);
    }
    slope += weight * (values[j] - values[kMiddle]);
  }
  return slope;
}

}  // namespace

MotionSign holdSign(std::span<const double> velocity, double widths, std::optional<double> dead_band) {
  MotionSign sign;
  sign.direction.assign(velocity.size(), 0);
  sign.keep.assign(velocity.size(), true);
  sign.dead_band = dead_band ? *dead_band : widths * noiseLevel(velocity);
  int last = 0;
  std::size_t last_row = 0;
  for (std::size_t i = 0; i < velocity.size(); ++i) {
    sign.direction[i] = static_cast<signed char>(last);
    if (std::abs(velocity[i]) <= sign.dead_band || velocity[i] == 0.0) continue;
    const int now = velocity[i] > 0.0 ? 1 : -1;
    // In long rests single rows leave the dead band by chance: a reversal takes two in a row, or one far outside.
    const bool lasts = i + 1 < velocity.size() && now * velocity[i + 1] > sign.dead_band;
    if (last != 0 && now != last && !lasts && std::abs(velocity[i]) <= 2.0 * sign.dead_band) continue;
    if (last == 0) {
      std::fill_n(sign.keep.begin(), i, false);
    } else if (now != last) {
      const std::size_t turn = turningPoint(velocity, last_row, i, now, sign.dead_band);
      std::fill(sign.direction.begin() + turn, sign.direction.begin() + i, static_cast<signed char>(now));
      sign.keep[turn - 1] = sign.keep[turn] = false;
      ++sign.reversals;
    }
    sign.direction[i] = static_cast<signed char>(now);
    last = now;
    last_row = i;
  }
  if (last == 0) std::fill(sign.keep.begin(), sign.keep.end(), false);
  return sign;
}

MotionSign rawSign(std::span<const double> velocity) {
  MotionSign sign;
  sign.keep.assign(velocity.size(), true);
  for (const double v : velocity) sign.direction.push_back(static_cast<signed char>((v > 0.0) - (v < 0.0)));
  return sign;
}

std::vector<double> smooth(std::span<const double> time, std::span<const double> values, double bandwidth) {
  const std::size_t n = values.size();
  if (n < 4) return {values.begin(), values.end()};
  const double mean_step = (time[n - 1] - time[0]) / static_cast<double>(n - 1);
  // sin instead of its argument: exact for even steps also near the Nyquist frequency.
  const double phase = std::min(std::numbers::pi * bandwidth * mean_step, std::numbers::pi / 2.0);
  const double weight = std::pow(2.0 * std::sin(phase), -6.0);
  // (1 + weight D^T D) x = values has seven diagonals. Its factor L diag(d) L^T is made row by row, and L^-1 values
  // with it: of a long log nothing is held but three numbers a row.
  std::vector<double> smoothed(n);
  std::vector<std::array<double, 3>> lower(n);  // row i of L, left of the diagonal: at i - 3, i - 2, i - 1
  std::array<double, 3> d = {1.0, 1.0, 1.0};    // of the last three rows, oldest first
  std::array<double, 3> z = {};                 // likewise, of L^-1 values
  std::array<Eigen::Vector4d, 4> rows;          // of D, that reach this row; row m stands at m % 4
  rows.fill(Eigen::Vector4d::Zero());
  for (std::size_t i = 0; i < n; ++i) {
    rows[i % 4] = i + 3 < n ? thirdDifference(time, i, mean_step) : Eigen::Vector4d(Eigen::Vector4d::Zero());
    std::array<double, 4> a = {};  // row i of the matrix, at i - 3 … i
    for (std::size_t m = i < 3 ? 0 : i - 3; m <= i; ++m) {
      const Eigen::Vector4d& row = rows[m % 4];
      for (std::size_t k = m; k <= i; ++k) a[3 + k - i] += weight * row[i - m] * row[k - m];
    }
    const std::array<double, 3>& before = i > 0 ? lower[i - 1] : lower[0];
    const double y3 = a[0];
    const double y2 = a[1] - (i > 1 ? lower[i - 2][2] * y3 : 0.0);
    const double y1 = a[2] - (i > 0 ? before[1] * y3 + before[2] * y2 : 0.0);
    std::array<double, 3>& l = lower[i];
    l = {y3 / d[0], y2 / d[1], y1 / d[2]};
    const double pivot = 1.0 + a[3] - l[0] * y3 - l[1] * y2 - l[2] * y1;
    const double forward = values[i] - l[0] * z[0] - l[1] * z[1] - l[2] * z[2];
    d = {d[1], d[2], pivot};
    z = {z[1], z[2], forward};
    smoothed[i] = forward / pivot;
  }
  for (std::size_t i = n; i-- > 0;) {
    for (std::size_t k = 1; k <= 3 && i + k < n; ++k) smoothed[i] -= lower[i + k][3 - k] * smoothed[i + k];
  }
  return smoothed;
}

std::vector<Block> splitRuns(std::span<const double> time, std::span<const int> session) {
  constexpr double kGap = 8.0;  // usual steps
  constexpr std::size_t kFewestRows = 8;
  std::vector<Block> runs;
  for (const Block& rows : splitRows(session, session.size())) {
    std::vector<double> steps;
    for (std::size_t i = rows.begin + 1; i < rows.end; ++i) steps.push_back(time[i] - time[i - 1]);
    // Not the median: where rows come in bursts most steps are far too short.
    const double gap = steps.empty() ? 0.0 : kGap * quantile(std::move(steps), 0.9);
    std::size_t begin = rows.begin;
    for (std::size_t i = rows.begin + 1; i < rows.end; ++i) {
      if (time[i] - time[i - 1] <= gap || i - begin < kFewestRows || rows.end - i < kFewestRows) continue;
      runs.push_back({begin, i});
      begin = i;
    }
    runs.push_back({begin, rows.end});
  }
  return runs;
}

std::vector<double> smoothRuns(std::span<const double> time, std::span<const double> values,
                               std::span<const Block> runs, double bandwidth) {
  std::vector<double> smoothed(values.begin(), values.end());
  for (const Block& run : runs) {
    std::ranges::copy(smooth(time.subspan(run.begin, run.size()), values.subspan(run.begin, run.size()), bandwidth),
                      smoothed.begin() + static_cast<std::ptrdiff_t>(run.begin));
  }
  return smoothed;
}

double samplingRate(std::span<const double> time, std::span<const Block> runs) {
  double seconds = 0.0;
  std::size_t steps = 0;
  for (const Block& run : runs) {
    seconds += time[run.end - 1] - time[run.begin];
    steps += run.size() - 1;
  }
  return seconds > 0.0 ? static_cast<double>(steps) / seconds : 0.0;
}

std::vector<double> differentiate(std::span<const double> time, std::span<const double> values) {
  const std::size_t n = values.size();
  std::vector<double> slope(n);
  const auto secant = [&](std::size_t i) { return (values[i + 1] - values[i]) / (time[i + 1] - time[i]); };
  const auto central = [&](std::size_t i) {
    const double before = time[i] - time[i - 1], after = time[i + 1] - time[i];
    return (after * secant(i - 1) + before * secant(i)) / (before + after);
  };
  slope[0] = secant(0);
  slope[n - 1] = secant(n - 2);
  for (std::size_t i = 1; i + 1 < n; ++i) {
    const bool inside = i > 1 && i + 2 < n && hasEvenSteps(time.subspan(i - 2, 5));
    slope[i] = inside ? slopeOfFive(time.subspan(i - 2, 5), values.subspan(i - 2, 5)) : central(i);
  }
  return slope;
}

}  // namespace simgap
