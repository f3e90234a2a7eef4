#include "paired_error.h"

#include <algorithm>
#include <cmath>
#include <numeric>
#include <vector>

#include "simgap/core/random.h"
#include "simgap/core/statistics.h"

namespace simgap {

using Eigen::ArrayXd;
using Eigen::Index;

namespace {

/// \param draws  of a bootstrap
Interval percentiles(double value, std::vector<double>& draws) {
  std::ranges::sort(draws);
  const std::size_t tail = draws.size() / 40;
  return {value, draws[tail], draws[draws.size() - 1 - tail]};
}

}  // namespace

Interval pairedGain(const GroupErrors& before, const GroupErrors& after, std::uint64_t seed) {
  constexpr int kDraws = 1000;
  constexpr Index kRun = 4;
  const Index n = before.sum.size();
  const double value = 1.0 - after.sum.sum() / std::max(before.sum.sum(), 1e-300);
  if (n < 2) return {value, value, value};
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
    draws[d] = 1.0 - sum_after / std::max(sum_before, 1e-300);
  }
  return percentiles(value, draws);
}

Interval pairedGain(std::span<const double> before, std::span<const double> after, std::uint64_t seed) {
  constexpr std::uint32_t kDraws = 2000, kPurpose = 21;
  const CounterRandom random(seed);
  const auto toArray = [](std::span<const double> values) -> ArrayXd {
    return Eigen::Map<const ArrayXd>(values.data(), std::ssize(values));
  };
  const ArrayXd all_before = toArray(before), all_after = toArray(after);
  std::vector<double> draws(kDraws);
  for (std::uint32_t draw = 0; draw < kDraws; ++draw) {
    draws[draw] = resampledGain(all_before, all_after, random, draw, kPurpose);
  }
  const double sum_before = std::accumulate(before.begin(), before.end(), 0.0);
  const double sum_after = std::accumulate(after.begin(), after.end(), 0.0);
  return percentiles(sum_before > 0.0 ? 1.0 - sum_after / sum_before : 0.0, draws);
}

double resampledGain(const ArrayXd& before, const ArrayXd& after, const CounterRandom& random, std::uint32_t draw,
                     std::uint32_t purpose) {
  double sum_before = 0.0, sum_after = 0.0;
  for (Index k = 0; k < before.size(); ++k) {
    const double u = random.uniform({draw, static_cast<std::uint32_t>(k), 0, purpose});
    const auto piece = static_cast<Index>(u * static_cast<double>(before.size()));
    sum_before += before[piece];
    sum_after += after[piece];
  }
  return 1.0 - sum_after / std::max(sum_before, 1e-300);
}

double logOdds(double gain) {
  constexpr double kSmallest = 0.002, kLargest = 1.0 - 1e-9;
  const double g = std::clamp(gain, kSmallest, kLargest);
  return std::log(g / (1.0 - g));
}

double inverseLogOdds(double odds) { return 1.0 / (1.0 + std::exp(-odds)); }

Interval predictedGain(const ArrayXd& before, const ArrayXd& after, std::uint64_t seed) {
  constexpr std::size_t kDraws = 4000;
  const CounterRandom random(seed);
  const double value = 1.0 - after.sum() / std::max(before.sum(), 1e-300);
  std::vector<double> differences, ratios;
  for (std::uint32_t draw = 0; draw < kDraws; ++draw) {
    const double here = resampledGain(before, after, random, draw, 1);
    const double there = resampledGain(before, after, random, draw, 2);
    differences.push_back(there - here);
    ratios.push_back(logOdds(there) - logOdds(here));
  }
  std::ranges::sort(differences);
  std::ranges::sort(ratios);
  // Few pieces vary less than what they were drawn from: wider quantiles (expanded percentiles: Hesterberg 2015).
  const auto n = static_cast<double>(before.size());
  const double z = n > 1.0 ? studentQuantile(n - 1.0) * std::sqrt(n / (n - 1.0)) : 0.0;
  const auto tail = static_cast<std::size_t>(normalTail(z) * kDraws);
  const double low = value + differences[tail], high = value + differences[kDraws - 1 - tail];
  if (value <= 0.0) return {value, std::min(value, low), std::max(value, high)};
  return {value, std::min(value, inverseLogOdds(logOdds(value) + ratios[tail])),
          std::max({value, std::min(high, 1.0), inverseLogOdds(logOdds(value) + ratios[kDraws - 1 - tail])})};
}

namespace {

/// By how much the variance of a mean grows because neighbours are alike (AR(1)).
double inflation(const std::vector<double>& values, double mean) {
  double squares = 1e-300, neighbours = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    squares += (values[i] - mean) * (values[i] - mean);
    if (i > 0) neighbours += (values[i] - mean) * (values[i - 1] - mean);
  }
  const double rho = std::clamp(neighbours / squares, 0.0, 0.9);
  return (1.0 + rho) / (1.0 - rho);
}

/// One-sided p-value of a mean of 0 or less.
double meanTest(const std::vector<double>& values) {
  const auto n = static_cast<double>(values.size());
  double mean = 0.0, squares = 0.0;
  for (const double v : values) mean += v / n;
  for (const double v : values) squares += (v - mean) * (v - mean);
  if (squares <= 0.0) return mean > 0.0 ? 0.0 : 1.0;
  return studentTail(mean / std::sqrt(squares / (n - 1.0) / n * inflation(values, mean)), n - 1.0);
}

/// The same of a symmetric distribution's centre, by signed ranks (Wilcoxon 1945).
double rankTest(const std::vector<double>& values) {
  std::vector<std::size_t> order(values.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return std::abs(values[i]); });
  std::vector<double> ranks(values.size());
  double sum = 0.0, squares = 0.0;
  for (std::size_t k = 0; k < order.size(); ++k) {
    const double rank = static_cast<double>(k + 1);
    const double v = values[order[k]];
    ranks[order[k]] = v > 0.0 ? rank : v < 0.0 ? -rank : 0.0;
    sum += ranks[order[k]];
    squares += rank * rank;
  }
  return normalTail(sum / std::sqrt(squares * inflation(ranks, sum / static_cast<double>(values.size()))));
}

}  // namespace

double pairedP(const GroupErrors& before, const GroupErrors& after) {
  if (before.sum.size() < 4) return 1.0;
  std::vector<double> differences, ratios;
  for (Index k = 0; k < before.sum.size(); ++k) {
    differences.push_back(before.sum[k] - after.sum[k]);
    ratios.push_back(std::log(std::max(before.sum[k], 1e-300) / std::max(after.sum[k], 1e-300)));
  }
  const double tests[] = {meanTest(differences), meanTest(ratios), rankTest(differences)};
  return combinedP(tests);
}

namespace {

/// One-sided p-value of a slope of 0 or less.
double slopeTest(const Nested& pieces) {
  const double squares = pieces.squares.sum(), slope = pieces.products.sum() / std::max(squares, 1e-300);
  std::vector<double> influences;  // of each piece on the slope
  double variance = 0.0;
  for (Index k = 0; k < pieces.products.size(); ++k) {
    const double others = std::max(squares - pieces.squares[k], 1e-300);
    influences.push_back((pieces.products[k] - slope * pieces.squares[k]) / others);
    variance += influences.back() * influences.back();
  }
  if (variance <= 0.0) return slope > 0.0 ? 0.0 : 1.0;
  const double carried = squares * squares / std::max(pieces.squares.square().sum(), 1e-300);
  return studentTail(slope / std::sqrt(variance * inflation(influences, 0.0)), carried - 1.0);
}

}  // namespace

double nestedP(const Nested& pieces) {
  if (pieces.products.size() < 4) return 1.0;
  const double tests[] = {slopeTest(pieces), rankTest({pieces.products.begin(), pieces.products.end()})};
  return combinedP(tests);
}

}  // namespace simgap
