/// \file
/// What a channel does to a friction fit that is logged some milliseconds late. Taken as simultaneous, a third of a row
/// moves k_v and the Coulomb terms by several of their standard deviations (SlowIntervalCoverage).
#pragma once

#include <Eigen/Core>
#include <optional>
#include <span>

#include "simgap/measure/logs/friction_rows.h"
#include "simgap/optimize/least_squares.h"
#include "simgap/optimize/uncertainty.h"

namespace simgap {

/// Name of the parameter that `withDelay` appends.
inline constexpr char kEffortDelay[] = "effort_delay";

/// Between two rows that follow each other, on average [s].
double rowSeconds(const FrictionData& data);

/// The problem with a parameter more: by how much the target comes later than what it is predicted from [s]. To first
/// order, target(t) = f(t) - delay df/dt, with the rate of what is predicted at `theta`. \param target  shape (rows).
/// `problem`, `data` and `target` must outlive it.
LeastSquaresProblem withDelay(const LeastSquaresProblem& problem, const FrictionData& data,
                              const Eigen::ArrayXd& target, const std::vector<double>& theta);

/// What a fit that knows of no delay would change if it did.
struct DelayEffect {
  Eigen::VectorXd shift;     ///< shape (P): of the problem's own parameters; 0 for what is fixed or on a bound
  Eigen::VectorXd widening;  ///< shape (P): factor of their standard deviations when the delay has to be found, too
  double delay, sd;          ///< [s]
};

/// By one Gauss-Newton step from `theta`, in one pass over the rows. Empty where the delay does not exceed twice its
/// standard deviation. \param theta  shape (P + 1): the fit's, and 0.
std::optional<DelayEffect> delayEffect(const LeastSquaresProblem& delayed, std::span<const double> theta,
                                       std::span<const int> session);

}  // namespace simgap
