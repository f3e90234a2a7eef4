/// \file
/// What a friction fit leaves out and every bench has: a channel that is logged some milliseconds late, and the inertia
/// of the rotor, which no load at the joint holds. Taken as simultaneous, a third of a row moves k_v and the Coulomb
/// terms by several of their standard deviations; the torque of a rotor goes with that of a lever's weight, and so
/// moves k_a (SlowIntervalCoverage).
#pragma once

#include <Eigen/Core>
#include <array>
#include <optional>
#include <span>

#include "simgap/measure/logs/friction_rows.h"
#include "simgap/optimize/least_squares.h"
#include "simgap/optimize/uncertainty.h"

namespace simgap {

/// Names of the parameters that `withLeftOut` appends, in this order.
inline constexpr std::array kLeftOut = {"effort_delay", "effort_per_acceleration"};
enum LeftOut : std::size_t { kDelay, kInertia };

/// Between two rows that follow each other, on average [s].
double rowSeconds(const FrictionData& data);

/// Of the motor, shape (rows): slope of the velocity over the rows of a tenth of a second that follow each other; 0 for
/// a row that stands alone.
Eigen::ArrayXd slopeOfVelocity(const FrictionData& data);

/// The problem with two parameters more: by how much the target comes later than what it is predicted from [s], and
/// what the target is more per acceleration. To first order, target(t) = f(t) - delay df/dt + inertia dw/dt, with the
/// rate of what is predicted at `theta`. Where the load is a bench's, worked out from the acceleration, the second one
/// is fixed: it could not be told from the bench's own inertia. \param target, acceleration  shape (rows). All
/// arguments but `theta` must outlive it.
LeastSquaresProblem withLeftOut(const LeastSquaresProblem& problem, const FrictionData& data,
                                const Eigen::ArrayXd& target, const Eigen::ArrayXd& acceleration,
                                const std::vector<double>& theta);

/// What a fit that knows of neither would change if it did.
struct LeftOutEffect {
  Eigen::VectorXd shift;     ///< shape (P): of the problem's own parameters; 0 for what is fixed or on a bound
  Eigen::VectorXd widening;  ///< shape (P): factor of their standard deviations when what was left out is found, too
  std::array<double, 2> value{}, sd{};  ///< by LeftOut; 0 where it is not seen
};

/// By one Gauss-Newton step from `theta`, in one pass over the rows. What does not exceed twice its standard deviation
/// counts for nothing; empty where none does. \param theta  shape (P + 2): the fit's, and zeros.
std::optional<LeftOutEffect> leftOutEffect(const LeastSquaresProblem& with_left_out, std::span<const double> theta,
                                           std::span<const int> session);

}  // namespace simgap
