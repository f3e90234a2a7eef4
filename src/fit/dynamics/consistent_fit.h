/// \file
/// A robot that can exist, from a log's sums and the robot's file as prior.
#pragma once

#include <vector>

#include "simgap/fit/dynamics/base_fit.h"

namespace simgap {

struct ConsistentFit {
  Eigen::VectorXd parameters;       ///< shape (P)
  Eigen::VectorXd sd, prior_sd;     ///< shape (P)
  Eigen::MatrixXd base_covariance;  ///< shape (K, K): of the base parameters that they make up
  bool converged = true;
};

/// \param variance  shape (N): of the residuals [torque^2]. \param inflation  by how much a row counts less than an
/// independent one. \param constants  shape (N) [N m/A]
ConsistentFit fitConsistent(const DynamicsData& data, const std::vector<JointSums>& sums,
                            const std::vector<double>& variance, double inflation,
                            const std::vector<double>& constants);

}  // namespace simgap
