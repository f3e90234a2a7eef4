/// \file
/// Least squares of base parameters on a log's sums.
#pragma once

#include <vector>

#include "simgap/fit/dynamics/dynamics_fit.h"

namespace simgap {

struct BaseSolution {
  Eigen::VectorXd x;             ///< shape (K); the shortest where the log leaves a choice
  Eigen::MatrixXd inverse;       ///< shape (K, K): of the weighed normal matrix, without what is not determined
  std::vector<bool> determined;  ///< shape (K)
  std::vector<double> variance;  ///< shape (N): of a joint's residual [torque^2]
};

/// Iterates the joints' weights. \param constants  shape (N) [N m/A]
BaseSolution solveBase(const DynamicsData& data, const std::vector<JointSums>& sums,
                       const std::vector<double>& constants);

/// Covariance of the solution by the jackknife over blocks (uncertainty.h), shape (K, K).
/// \param used  shape (blocks): those that it was found from
Eigen::MatrixXd jackknifeCovariance(const DynamicsData& data, const BaseSolution& solution,
                                    const std::vector<double>& constants, const std::vector<bool>& used);

/// Mean factor by which that is larger than for independent residuals; >= 1.
double inflationOf(const DynamicsData& data, const std::vector<JointSums>& sums, const BaseSolution& solution,
                   const Eigen::MatrixXd& covariance);

/// Sum of squared errors of a joint [torque^2] for base parameters x. \param constant  k
double squaredError(const JointSums& sums, const std::vector<std::size_t>& acts, const Eigen::VectorXd& x,
                    double constant);

/// A joint alone: offset and friction by its own rows, as factors of the columns of `sums`; 0 for all others.
Eigen::VectorXd fitAlone(const DynamicsData& data, const JointSums& sums, std::size_t joint);
/// Sum of squared errors of that [effort^2].
double squaredErrorAlone(const JointSums& sums, const Eigen::VectorXd& own);

}  // namespace simgap
