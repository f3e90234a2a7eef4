#include "simgap/optimize/pooling.h"

#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <boost/math/tools/toms748_solve.hpp>
#include <cassert>
#include <cmath>
#include <numeric>

#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Estimates = std::span<const GroupEstimate>;

constexpr double kFewestFreedoms = 0.25;  // of Student's t; below, nothing is known of the scatter

struct WeightedMean {
  double value = 0.0, precision = 0.0;
};

WeightedMean meanUnder(Estimates estimates, double variance) {
  WeightedMean mean;
  for (const GroupEstimate& e : estimates) {
    const double weight = 1.0 / (e.sd * e.sd + variance);
    mean.value += weight * e.value;
    mean.precision += weight;
  }
  mean.value /= mean.precision;
  return mean;
}

/// Q(tau^2), which falls as tau^2 grows.
double heterogeneity(Estimates estimates, double variance) {
  const double mean = meanUnder(estimates, variance).value;
  double q = 0.0;
  for (const GroupEstimate& e : estimates) q += std::pow(e.value - mean, 2) / (e.sd * e.sd + variance);
  return q;
}

/// The variance at which a falling function of it reaches `target`; 0 where it is below from the start.
template <typename Falling>
double varianceWhere(Falling&& q, double target, double scale) {
  if (q(0.0) <= target) return 0.0;
  double upper = scale;
  while (q(upper) > target) upper *= 4.0;
  std::uintmax_t iterations = 200;
  const auto bracket = boost::math::tools::toms748_solve([&](double v) { return q(v) - target; }, 0.0, upper,
                                                         boost::math::tools::eps_tolerance<double>(40), iterations);
  return std::midpoint(bracket.first, bracket.second);
}

/// A scale of tau^2 to search from: never 0, whatever the values.
double varianceScale(Estimates estimates) {
  double scale = 0.0;
  for (const GroupEstimate& e : estimates) scale = std::max(scale, e.sd * e.sd);
  return scale;
}

/// As many groups of one precision tell as much (Kish 1965): one that is known far better than the others is alone.
double groupsThatCount(Estimates estimates, double variance) {
  double sum = 0.0, squares = 0.0;
  for (const GroupEstimate& e : estimates) {
    const double weight = 1.0 / (e.sd * e.sd + variance);
    sum += weight;
    squares += weight * weight;
  }
  return sum * sum / squares;
}

/// A straight line over the order of the groups, with a scatter of that variance.
struct LineFit {
  double q;  ///< what is left with that scatter as noise
  GroupEstimate slope;
};

LineFit lineThrough(Estimates estimates, double variance) {
  double s = 0.0, sx = 0.0, sxx = 0.0, sy = 0.0, sxy = 0.0;
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const double w = 1.0 / (estimates[i].sd * estimates[i].sd + variance), x = static_cast<double>(i);
    s += w, sx += w * x, sxx += w * x * x, sy += w * estimates[i].value, sxy += w * x * estimates[i].value;
  }
  const double determinant = s * sxx - sx * sx, slope = (s * sxy - sx * sy) / determinant,
               start = (sy - slope * sx) / s;
  LineFit line{0.0, {slope, std::sqrt(s / determinant)}};
  for (std::size_t i = 0; i < estimates.size(); ++i) {
    const GroupEstimate& e = estimates[i];
    line.q += std::pow(e.value - start - slope * static_cast<double>(i), 2) / (e.sd * e.sd + variance);
  }
  return line;
}

/// Two means, one before a group and one from it on, with the scatter that both share.
struct Split {
  double q;         ///< what is left with that scatter as noise
  double variance;  ///< tau^2 from Q_before + Q_after = k - 2
  GroupEstimate step;
};

Split splitAt(Estimates estimates, std::size_t first, std::optional<double> variance = {}) {
  const Estimates before = estimates.first(first), after = estimates.subspan(first);
  const auto q = [&](double v) { return heterogeneity(before, v) + heterogeneity(after, v); };
  Split split{};
  split.variance =
      variance ? *variance : varianceWhere(q, static_cast<double>(estimates.size() - 2), varianceScale(estimates));
  split.q = q(split.variance);
  const WeightedMean early = meanUnder(before, split.variance), late = meanUnder(after, split.variance);
  split.step = {late.value - early.value, std::sqrt(1.0 / early.precision + 1.0 / late.precision)};
  return split;
}

}  // namespace

PooledEstimate pool(Estimates estimates) {
  assert(estimates.size() >= 2);
  const double freedoms = static_cast<double>(estimates.size() - 1);
  const boost::math::chi_squared distribution(freedoms);
  const auto q = [&](double v) { return heterogeneity(estimates, v); };
  const auto scatterAt = [&](double target) { return std::sqrt(varianceWhere(q, target, varianceScale(estimates))); };
  PooledEstimate pooled{};
  pooled.scatter = scatterAt(freedoms);
  pooled.scatter_lower = scatterAt(quantile(distribution, 0.975));
  pooled.scatter_upper = scatterAt(quantile(distribution, 0.025));
  pooled.p_equal = cdf(complement(distribution, q(0.0)));

  const double variance = pooled.scatter * pooled.scatter;
  const WeightedMean mean = meanUnder(estimates, variance);
  pooled.mean = mean.value;
  // Hartung and Knapp: the spread that is seen scales the interval, but never below what the groups' own noise gives.
  const double seen = std::max(1.0, heterogeneity(estimates, variance) / freedoms);
  const double half = studentQuantile(freedoms) * std::sqrt(seen / mean.precision);
  pooled.mean_lower = mean.value - half;
  pooled.mean_upper = mean.value + half;

  for (const GroupEstimate& e : estimates) {
    // Posterior of mu + u_i: its own value and the mean of all, each by its precision.
    const double share = variance / (variance + e.sd * e.sd);
    const double sd = std::sqrt(share * e.sd * e.sd + std::pow(1.0 - share, 2) / mean.precision);
    pooled.groups.push_back({mean.value + share * (e.value - mean.value), sd});
  }
  return pooled;
}

std::optional<ChangePoint> findChange(Estimates estimates) {
  if (estimates.size() < 4) return {};
  const double freedoms = static_cast<double>(estimates.size() - 2);
  double clearest = -1.0;
  ChangePoint change{};
  double variance = 0.0;
  for (std::size_t first = 1; first < estimates.size(); ++first) {
    const Split split = splitAt(estimates, first);
    // tau is estimated beside the step, with k - 2 freedoms: Student's t, not a normal.
    const double t = std::abs(split.step.value) / (split.step.sd * std::sqrt(std::max(1.0, split.q / freedoms)));
    if (t <= clearest) continue;
    clearest = t;
    variance = split.variance;
    change.first = first;
    change.step = split.step;
  }
  // What drifts from group to group has no moment at which it changed.
  const bool drifts = lineThrough(estimates, variance).q <= splitAt(estimates, change.first, variance).q;
  const double counted = groupsThatCount(estimates, variance) - 2.0;
  change.p = 1.0;
  if (!drifts && counted > kFewestFreedoms) {
    // Any of the k - 1 places would have been reported: Bonferroni.
    const boost::math::students_t distribution(counted);
    change.p = std::min(1.0, 2.0 * cdf(complement(distribution, clearest)) * static_cast<double>(estimates.size() - 1));
  }
  // Places that fit as well as the best but for a likelihood ratio's 95 % quantile, with the best one's scatter.
  const double most = splitAt(estimates, change.first, variance).q + quantile(boost::math::chi_squared(1.0), 0.95);
  change.earliest = change.latest = change.first;
  for (std::size_t first = 1; first < estimates.size(); ++first) {
    if (splitAt(estimates, first, variance).q > most) continue;
    change.earliest = std::min(change.earliest, first);
    change.latest = std::max(change.latest, first);
  }
  return change;
}

std::optional<Drift> findDrift(Estimates estimates) {
  if (estimates.size() < 4) return {};
  const double freedoms = static_cast<double>(estimates.size() - 2);
  const auto left = [&](double v) { return lineThrough(estimates, v).q; };
  const double variance = varianceWhere(left, freedoms, varianceScale(estimates));
  const LineFit line = lineThrough(estimates, variance);
  bool steps = false;
  for (std::size_t first = 1; first < estimates.size() && !steps; ++first) {
    steps = splitAt(estimates, first, variance).q < line.q;
  }
  Drift drift{line.slope, 1.0};
  const double counted = groupsThatCount(estimates, variance) - 2.0;
  if (steps || counted <= kFewestFreedoms) return drift;
  const double t = std::abs(line.slope.value) / (line.slope.sd * std::sqrt(std::max(1.0, line.q / freedoms)));
  drift.p = 2.0 * cdf(complement(boost::math::students_t(counted), t));
  return drift;
}

std::vector<double> holmAdjusted(std::span<const double> p) {
  std::vector<std::size_t> order(p.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::ranges::stable_sort(order, {}, [&](std::size_t i) { return p[i]; });
  std::vector<double> adjusted(p.size());
  double largest = 0.0;
  for (std::size_t rank = 0; rank < order.size(); ++rank) {
    largest = std::max(largest, std::min(1.0, p[order[rank]] * static_cast<double>(p.size() - rank)));
    adjusted[order[rank]] = largest;
  }
  return adjusted;
}

}  // namespace simgap
