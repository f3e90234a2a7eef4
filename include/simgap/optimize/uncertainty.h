/// \file
/// How well fitted parameters are known when the residuals of neighbouring rows are alike. The covariance is the
/// jackknife over blocks of rows that are long against the residuals' correlation time (to first order; Bell &
/// McCaffrey 2002 call it CR3): it needs no model of the noise and holds where the residual is partly misfit. With too
/// few blocks it falls back on sigma^2 (J^T J)^-1 times the correlation time (the effective sample size).
#pragma once

#include <Eigen/Core>
#include <span>
#include <string>
#include <vector>

#include "simgap/optimize/least_squares.h"

namespace simgap {

struct Uncertainty {
  std::vector<Estimate> estimates;    ///< shape (P)
  Eigen::MatrixXd covariance;         ///< shape (P, P); 0 for what is fixed or not determined
  Eigen::MatrixXd correlation;        ///< shape (P, P)
  double correlation_rows = 1.0;      ///< integrated correlation time of the residuals, in rows
  double n_effective = 0.0;           ///< rows / correlation_rows
  std::size_t blocks = 0;             ///< of the jackknife; 0 after the fallback
  double quantile = 1.96;             ///< half width of a 95 % interval in standard deviations (Student)
  std::vector<std::string> findings;  ///< sentences: which parameters, or combinations, the data do not determine
};

/// The sentences of `findings`: undetermined parameters, and pairs of which only a combination is determined.
std::vector<std::string> describeUndetermined(const Uncertainty& result);

/// \param session  shape (rows): correlations and blocks do not reach over sessions.
Uncertainty estimateUncertainty(const LeastSquaresProblem& problem, std::span<const double> theta,
                                std::span<const int> session);

/// Adds what it does to the estimates that parameters were held at values known only with a covariance. To first order
/// the estimates move by -(J^T J)^-1 J^T J_held with the held ones.
/// \param held  places in theta. \param covariance  shape (held, held).
void addHeldUncertainty(const LeastSquaresProblem& problem, std::span<const double> theta, std::span<const int> held,
                        const Eigen::MatrixXd& covariance, Uncertainty& result);

/// The interval of a parameter k > 0 that acts as 1 / k: of that, turned round; without an end where 1 / k may be 0.
void knowByInverse(double quantile, const ParameterSpec& spec, Estimate& k);

/// The same of the parameters from `begin` to before `end` alone.
Uncertainty partOf(const Uncertainty& all, std::size_t begin, std::size_t end);

/// Integrated correlation time 1 + 2 sum rho(lag) in rows, >= 1, summed over the window of Sokal (1997).
double correlationTime(const Eigen::VectorXd& residual, std::span<const int> session);

}  // namespace simgap
