/// \file
/// Least squares of base parameters on a log's sums.
#pragma once

#include <functional>
#include <vector>

#include "simgap/fit/dynamics/dynamics_fit.h"

namespace simgap {

/// A x = b, weighed.
struct NormalEquations {
  Eigen::MatrixXd a;
  Eigen::VectorXd b;
};
/// Of a normal matrix, without the directions that it does not determine. \param determined  unless null, of which
/// unknowns it does
Eigen::MatrixXd weighedInverse(const Eigen::MatrixXd& a, std::vector<bool>* determined = nullptr);
/// Covariance of a solution by the jackknife over blocks (uncertainty.h). \param inverse  of all blocks' normal matrix
/// \param of_block  its own matrix, and its gradient at the solution; a matrix of 0: it has no part
Eigen::MatrixXd jackknifeOver(const Eigen::MatrixXd& inverse, std::size_t blocks,
                              const std::function<NormalEquations(std::size_t block)>& of_block);

/// Base parameters of the bodies in the robot's file, without friction and rotors, shape (K).
Eigen::VectorXd baseInFile(const DynamicsData& data);

struct BaseSolution {
  Eigen::VectorXd x;             ///< shape (K); the shortest where the log leaves a choice
  Eigen::MatrixXd inverse;       ///< shape (K, K): of the weighed normal matrix, without what is not determined
  std::vector<bool> determined;  ///< shape (K)
  std::vector<double> variance;  ///< shape (N): of a joint's residual [torque^2]
};

/// Iterates the joints' weights. \param constants  shape (N) [N m/A]
BaseSolution solveBase(const DynamicsData& data, const std::vector<JointSums>& sums,
                       const std::vector<double>& constants);

/// jackknifeOver of the solution, shape (K, K).
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
