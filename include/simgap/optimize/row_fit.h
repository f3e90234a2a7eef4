/// \file
/// Non-linear least squares on some blocks of a log's rows, for fits by the hundred: hypotheses times folds. Damped
/// Gauss-Newton (Levenberg 1944, Marquardt 1963) on normal equations with box bounds by an active set. It starts near
/// its minimum and its columns are scaled, so that the digits which normal equations lose do not matter.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "simgap/core/blocks.h"
#include "simgap/optimize/least_squares.h"

namespace simgap {

/// A model of all rows of a log at once.
class RowModel {
 public:
  virtual ~RowModel() = default;
  virtual const std::vector<ParameterSpec>& parameters() const = 0;  ///< shape (P)
  virtual Eigen::Index rows() const = 0;
  /// \param residual  shape (rows): predicted - measured; 0 in rows that do not count.
  /// \param jacobian  shape (rows, P), or null. Called from several threads at once.
  virtual void evaluate(std::span<const double> theta, Eigen::VectorXd& residual, Eigen::MatrixXd* jacobian) const = 0;
};

/// A model at one place: what several who ask for it there share.
struct RowEvaluation {
  RowEvaluation() = default;
  RowEvaluation(const RowModel& model, std::span<const double> place) : theta(place.begin(), place.end()) {
    model.evaluate(theta, residual, &jacobian);
  }

  std::vector<double> theta;  ///< shape (P)
  Eigen::VectorXd residual;   ///< shape (rows)
  Eigen::MatrixXd jacobian;   ///< shape (rows, P)
};

struct RowFit {
  std::vector<double> theta;  ///< shape (P)
  double cost = 0.0;          ///< sum of squares over the blocks
  int iterations = 0;
};

struct RowFitOptions {
  int max_iterations = 40;
  double tolerance = 1e-5;  ///< relative decrease of the cost that counts as none
};

/// J^T J over the rows of some blocks, shape (P, P).
Eigen::MatrixXd gramOf(const Eigen::MatrixXd& jacobian, std::span<const Block> blocks);

/// \param start  shape (P); moved into the bounds.
/// \param at_start  the model there, which then has to be within the bounds; null: it is not known
RowFit fitRows(const RowModel& model, std::span<const Block> blocks, std::vector<double> start,
               const RowFitOptions& options = {}, const RowEvaluation* at_start = nullptr);

/// Cost after one full Gauss-Newton step as the linearised model sees it: tells at which start to begin.
double linearisedCost(const RowModel& model, std::span<const Block> blocks, std::span<const double> start);

/// Covariance of theta from the scores of blocks, H^-1 (sum_b g_b g_b^T) H^-1 (sandwich: Liang & Zeger 1986); it holds
/// for correlated residuals. Shape (P, P), 0 for what is fixed, at a bound or without effect.
Eigen::MatrixXd blockCovariance(const RowModel& model, std::span<const Block> blocks, const RowEvaluation& at);

}  // namespace simgap
