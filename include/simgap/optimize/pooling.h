/// \file
/// Estimates of the same number from several groups (days, units, robots): what is common, how much they scatter, what
/// differs, and since when.
///
///   y_i ~ N(mu + u_i, s_i^2),   u_i ~ N(0, tau^2)
///
/// Q(tau^2) = sum_i (y_i - mu)^2 / (s_i^2 + tau^2), with mu the mean under these weights, is chi-squared with k - 1
/// degrees of freedom at the true tau^2. Q = k - 1 gives tau (R. C. Paule, J. Mandel, "Consensus values and weighting
/// factors", Journal of Research of the NBS 87, 1982), its quantiles give tau's interval (W. Viechtbauer, "Confidence
/// intervals for the amount of heterogeneity in meta-analysis", Statistics in Medicine 26, 2007), and Q(0) tests
/// whether all are equal. The interval of mu is Hartung's and Knapp's (Statistics in Medicine 20, 2001), which holds
/// for few groups, too.
#pragma once

#include <optional>
#include <span>
#include <vector>

namespace simgap {

struct GroupEstimate {
  double value;
  double sd;  ///< > 0
};

struct PooledEstimate {
  double mean;                          ///< mu
  double mean_lower, mean_upper;        ///< 95 % interval
  double scatter;                       ///< tau: standard deviation between groups, beyond what `sd` explains
  double scatter_lower, scatter_upper;  ///< 95 % interval
  double p_equal;                       ///< probability of such differences when all are equal
  std::vector<GroupEstimate> groups;    ///< shape (groups): each drawn towards the mean by as much as it is uncertain
};

/// \param estimates  at least two
PooledEstimate pool(std::span<const GroupEstimate> estimates);

/// A step between groups that follow each other in time.
struct ChangePoint {
  std::size_t first;             ///< group from which on the later value holds
  std::size_t earliest, latest;  ///< the same, with 95 % confidence
  GroupEstimate step;            ///< later minus earlier
  double p;                      ///< of a step as clear as this anywhere when there is only scatter; 1 where a drift
                                 ///< along the order explains as much
};

/// The step that explains most, judged against the scatter that is left beside it by Student's t. Its freedoms are
/// those of the groups that count, (sum w)^2 / sum w^2 - 2 with the weights w = 1 / (s_i^2 + tau^2) (L. Kish, "Survey
/// Sampling", 1965): two groups that are known well between many that are hardly known are no row of groups.
/// \returns nothing for fewer than four groups, which cannot tell a step from scatter.
std::optional<ChangePoint> findChange(std::span<const GroupEstimate> estimates);

/// A straight line over groups that follow each other in time.
struct Drift {
  GroupEstimate slope;  ///< from group to group
  double p;             ///< of a slope as clear as this when there is only scatter; 1 where a step explains more
};

/// The slope over the order of the groups, judged as findChange judges a step.
/// \returns nothing for fewer than four groups
std::optional<Drift> findDrift(std::span<const GroupEstimate> estimates);

/// Holm's step-down adjustment of p values that are looked at together, shape (tests).
std::vector<double> holmAdjusted(std::span<const double> p);

}  // namespace simgap
