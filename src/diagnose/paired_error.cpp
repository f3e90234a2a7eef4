#include "paired_error.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "simgap/core/random.h"

namespace simgap {

using Eigen::ArrayXd;
using Eigen::Index;

Interval pairedGain(const PieceErrors& before, const PieceErrors& after, std::uint64_t seed) {
  constexpr int kDraws = 1000;
  constexpr Index kRun = 4;
  const Index n = before.sum.size();
  Interval gain;
  gain.value = 1.0 - after.sum.sum() / std::max(before.sum.sum(), 1e-300);
  if (n < 2) return {gain.value, gain.value, gain.value};
  const Index run = std::min(kRun, std::max<Index>(1, n / 8));
  const CounterRandom random(seed);
  std::vector<double> draws(kDraws);
  for (int d = 0; d < kDraws; ++d) {
    double sum_before = 0.0, sum_after = 0.0;
    for (Index k = 0; k * run < n; ++k) {
      const double u =
          random.uniform({.generation = static_cast<std::uint32_t>(d), .individual = static_cast<std::uint32_t>(k)});
      const auto begin = static_cast<Index>(u * static_cast<double>(n));
      for (Index j = 0; j < run; ++j) {
        sum_before += before.sum[(begin + j) % n];
        sum_after += after.sum[(begin + j) % n];
      }
    }
    draws[static_cast<std::size_t>(d)] = 1.0 - sum_after / std::max(sum_before, 1e-300);
  }
  std::ranges::sort(draws);
  gain.lower95 = draws[kDraws / 40];
  gain.upper95 = draws[kDraws - 1 - kDraws / 40];
  return gain;
}

double pairedP(const PieceErrors& before, const PieceErrors& after) {
  const ArrayXd difference = before.sum - after.sum;
  const Index n = difference.size();
  if (n < 4) return 1.0;
  const double mean = difference.mean();
  double squares = 0.0, neighbours = 0.0;
  for (Index i = 0; i < n; ++i) {
    squares += (difference[i] - mean) * (difference[i] - mean);
    if (i > 0) neighbours += (difference[i] - mean) * (difference[i - 1] - mean);
  }
  const double variance = squares / static_cast<double>(n - 1);
  if (variance <= 0.0) return mean > 0.0 ? 0.0 : 1.0;
  const double rho = std::clamp(neighbours / squares, 0.0, 0.9);
  const double error = std::sqrt(variance / static_cast<double>(n) * (1.0 + rho) / (1.0 - rho));
  return 0.5 * std::erfc(mean / error / std::sqrt(2.0));
}

}  // namespace simgap
