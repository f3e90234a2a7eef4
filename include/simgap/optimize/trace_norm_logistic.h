/// \file
/// Logistic classification of symmetric matrices with a penalty on the sum of their weights' singular values: few
/// directions, however many entries.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

namespace simgap {

/// Symmetric matrices as rows of one matrix, so that the product of two rows is the trace of the matrices' product.
/// Shape (matrices, D (D + 1) / 2): the lower triangle by columns, off the diagonal times sqrt(2).
Eigen::MatrixXd packSymmetric(std::span<const Eigen::MatrixXd> matrices);
/// One such row as a matrix of shape (dimension, dimension).
Eigen::MatrixXd unpackSymmetric(const Eigen::VectorXd& packed, Eigen::Index dimension);

struct TraceNormOptions {
  double gap = 1e-6;  ///< largest duality gap, as a part of the objective
  int max_iterations = 20'000;
};

struct TraceNormFit {
  Eigen::VectorXd weights;  ///< packed W, shape (D (D + 1) / 2)
  double bias = 0.0;
  double objective = 0.0;
  double gap = 0.0;  ///< proven distance to the least objective, as a part of the objective
  int iterations = 0;
  bool converged = false;  ///< the gap was reached
};

/// min over W, b of sum_t ln(1 + exp(-q_t (tr(W C_t) + b))) + penalty |W|_1, the sum of W's singular values (Brain-
/// Controlled Exoskeleton Robot for BMI Rehabilitation, eq. 4-7), by accelerated proximal steps that restart (FISTA;
/// O'Donoghue and Candes), with the bias solved for at each. The gap is that to Fenchel's dual, which needs no solver
/// of matrix inequalities. \param packed  C, as packSymmetric  \param labels  q, shape (matrices): +1 or -1, both of
/// them there \param start  weights to begin from; empty: none. \throws InterruptedError
TraceNormFit fitTraceNormLogistic(const Eigen::MatrixXd& packed, const Eigen::VectorXd& labels, Eigen::Index dimension,
                                  double penalty, const TraceNormOptions& options = {},
                                  const Eigen::VectorXd& start = {});

/// From this penalty on all weights are zero.
double largestTraceNormPenalty(const Eigen::MatrixXd& packed, const Eigen::VectorXd& labels, Eigen::Index dimension);

/// The mean of ln(1 + exp(-q a)).
double logisticLoss(const Eigen::VectorXd& log_odds, const Eigen::VectorXd& labels);

}  // namespace simgap
