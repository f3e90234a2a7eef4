/// \file
/// A robot that can exist, from a log's sums and the robot's file as prior.
#pragma once

#include <optional>
#include <vector>

#include "base_fit.h"

namespace simgap {

struct ConsistentFit {
  DynamicsModel model;
  Eigen::VectorXd sd, prior_sd;     ///< shape (P)
  std::vector<double> constant_sd;  ///< shape (N), relative
  bool converged = true;
};

/// \param variance  shape (N): of the residuals, of torque where the constants are given, else of the effort.
/// \param inflation  by how much a row counts less than an independent one.
/// \param constants  shape (N): given, or to start from. \param fit_constants  they are found, too.
ConsistentFit fitConsistent(const DynamicsData& data, const std::vector<JointSums>& sums,
                            const std::vector<double>& variance, double inflation, const std::vector<double>& constants,
                            bool fit_constants);

/// Torque constants with which the file's bodies come nearest to the log, each joint by itself; a start.
std::vector<double> guessConstants(const DynamicsData& data, const std::vector<JointSums>& sums);

}  // namespace simgap
