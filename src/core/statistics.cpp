#include "simgap/core/statistics.h"

#include <Eigen/Core>
#include <algorithm>
#include <boost/math/distributions/chi_squared.hpp>
#include <boost/math/distributions/fisher_f.hpp>
#include <boost/math/distributions/students_t.hpp>
#include <cassert>
#include <cmath>
#include <numbers>

namespace simgap {

double quantile(std::vector<double> values, double share) {
  assert(!values.empty() && share >= 0.0 && share < 1.0);
  const auto at = values.begin() + static_cast<std::ptrdiff_t>(share * static_cast<double>(values.size()));
  std::nth_element(values.begin(), at, values.end());
  return *at;
}

double median(std::vector<double> values) {
  assert(!values.empty());
  const auto upper = values.begin() + std::ssize(values) / 2;
  std::nth_element(values.begin(), upper, values.end());
  return values.size() % 2 == 1 ? *upper : 0.5 * (*std::max_element(values.begin(), upper) + *upper);
}

double upperMedian(std::vector<double> values) { return quantile(std::move(values), 0.5); }

double robustDeviation(std::vector<double> values) {
  for (double& value : values) value = std::abs(value);
  return upperMedian(std::move(values)) / kMedianOfNormal;
}

double standardDeviation(std::span<const double> values) {
  assert(!values.empty());
  const Eigen::Map<const Eigen::ArrayXd> all(values.data(), std::ssize(values));
  return std::sqrt((all - all.mean()).square().mean());
}

double correlation(std::span<const double> a, std::span<const double> b) {
  assert(a.size() == b.size());
  using Values = Eigen::Map<const Eigen::ArrayXd>;
  const Values first(a.data(), std::ssize(a)), second(b.data(), std::ssize(b));
  const Eigen::ArrayXd x = first - first.mean(), y = second - second.mean();
  return (x * y).sum() / std::max(std::sqrt(x.square().sum() * y.square().sum()), 1e-300);
}

double studentQuantile(double degrees_of_freedom) {
  return boost::math::quantile(boost::math::students_t(std::max(degrees_of_freedom, 1.0)), 0.975);
}

double normalTail(double z) { return 0.5 * std::erfc(z / std::numbers::sqrt2); }

double studentTail(double t, double degrees_of_freedom) {
  if (!std::isfinite(t)) return std::isnan(t) ? t : t > 0.0 ? 0.0 : 1.0;
  return boost::math::cdf(boost::math::complement(boost::math::students_t(std::max(degrees_of_freedom, 1.0)), t));
}

double combinedP(std::span<const double> p) {
  double mean = 0.0;  // of cotangents of p pi, standard Cauchy variables, hence one itself
  for (const double one : p) mean += 1.0 / (std::tan(one * std::numbers::pi) * static_cast<double>(p.size()));
  return mean > 1.0 ? std::atan(1.0 / mean) / std::numbers::pi : 0.5 - std::atan(mean) / std::numbers::pi;
}

double chiSquaredTail(double value, int degrees_of_freedom) {
  if (value <= 0.0) return 1.0;
  if (!std::isfinite(value)) return std::isnan(value) ? value : 0.0;
  return boost::math::cdf(boost::math::complement(boost::math::chi_squared(degrees_of_freedom), value));
}

double fisherTail(double value, double above, double below) {
  if (value <= 0.0) return 1.0;
  if (!std::isfinite(value)) return std::isnan(value) ? value : 0.0;
  return boost::math::cdf(boost::math::complement(boost::math::fisher_f(above, below), value));
}

}  // namespace simgap
