/// \file
/// Order statistics, and the distributions that intervals and tests need.
#pragma once

#include <span>
#include <vector>

namespace simgap {

/// The value with a share of the others below it: element floor(share n) of the n sorted values, so one that occurred.
/// \param values  not empty  \param share  in [0, 1)
double quantile(std::vector<double> values, double share);

/// The mean of the two middle values when there are two. \param values  not empty
double median(std::vector<double> values);

/// Of the two middle values, when there are two, the larger one: what robust scales are made of.
/// \param values  not empty
double upperMedian(std::vector<double> values);

/// Median of |x| of a normal x with standard deviation 1.
inline constexpr double kMedianOfNormal = 0.6744897501960817;

/// Standard deviation about 0 from the median size: median |x| / 0.6745. Half of the values may be anything.
/// \param values  not empty; their unit is the result's
double robustDeviation(std::vector<double> values);

/// About their mean, of all of them. \param values  not empty
double standardDeviation(std::span<const double> values);

/// Pearson's correlation; 0 where one of them is constant. \param a, b  of one length
double correlation(std::span<const double> a, std::span<const double> b);

/// 97.5 % quantile of Student's t, the factor of a two-sided 95 % interval. \param degrees_of_freedom  below 1 counts
/// as 1.
double studentQuantile(double degrees_of_freedom);

/// 97.5 % quantile of a standard normal: half the width of a 95 % interval in standard deviations.
inline constexpr double kNormalQuantile = 1.959963984540054;

/// P(x > z) of a standard normal x.
double normalTail(double z);

/// P(x > t) of Student's t. \param degrees_of_freedom  below 1 counts as 1
double studentTail(double t, double degrees_of_freedom);

/// One p-value of several tests of the same hypothesis, however much they depend on each other (Liu & Xie 2020).
/// \param p  not empty, in [0, 1]
double combinedP(std::span<const double> p);

/// P(x > value) of a chi-squared x. \param degrees_of_freedom  >= 1
double chiSquaredTail(double value, int degrees_of_freedom);
/// P(F > value) of a ratio of two variances. \param above, below  their degrees of freedom
double fisherTail(double value, double above, double below);

}  // namespace simgap
