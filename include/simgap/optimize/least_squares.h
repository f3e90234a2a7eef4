/// \file
/// Bounded, optionally robust non-linear least squares: Ceres' trust region on residuals that are evaluated in chunks
/// of rows. Each chunk is reduced to its triangular factor by a QR decomposition (TSQR: Demmel et al. 2012), so that a
/// log of 250,000 rows reaches Ceres as a problem of some ten rows with the same cost, gradient and Gauss-Newton
/// matrix, and without the loss of digits of normal equations. Results do not depend on the number of threads.
#pragma once

#include <Eigen/Core>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "simgap/core/blocks.h"
#include "simgap/optimize/parameter.h"

namespace simgap {

enum class LossKind { kSquares, kHuber, kCauchy, kTukey };

/// rho(r^2) with its transition at `scale`.
struct Loss {
  LossKind kind = LossKind::kSquares;
  double scale = 1.0;  ///< in the residual's unit
};

struct LeastSquaresProblem {
  std::vector<ParameterSpec> parameters;  ///< shape (P)
  std::vector<Block> chunks;              ///< rows that are evaluated together, in order
  /// Fills the residuals of a chunk, shape (n), and, unless null, their derivatives, shape (n, P). Called from several
  /// threads at once.
  std::function<void(std::span<const double> theta, const Block& rows, Eigen::Ref<Eigen::VectorXd> residual,
                     Eigen::Ref<Eigen::MatrixXd>* jacobian)>
      evaluate;
  Loss loss;

  std::size_t rows() const { return chunks.empty() ? 0 : chunks.back().end; }
  std::vector<int> freeParameters() const;
};

/// Chunks of equal size over `rows` rows.
std::vector<Block> evenChunks(std::size_t rows, std::size_t size = 2048);

struct LeastSquaresOptions {
  int max_iterations = 200;
  double function_tolerance = 1e-13;
  double parameter_tolerance = 1e-11;
  /// First radii of the trust region; the solver runs from each and the lowest cost wins. A small one also reaches
  /// minima that the first long step would jump over.
  std::vector<double> radii = {1e4};
  /// Steps within a plane of two directions (subspace dogleg: Byrd, Schnabel & Shultz 1988) instead of Levenberg and
  /// Marquardt's, which creep along narrow curved valleys.
  bool dogleg = false;
};

struct LeastSquaresResult {
  std::vector<double> theta;  ///< shape (P)
  double cost = 0.0;          ///< sum of rho(r^2): the sum of squares without a robust loss
  bool converged = false;
  int iterations = 0;
  std::string message;  ///< why it stopped
};

/// \param start  shape (P); moved into the bounds.
LeastSquaresResult minimise(const LeastSquaresProblem& problem, std::vector<double> start,
                            const LeastSquaresOptions& options = {});

/// Sorts what several starts found by its cost, lowest first. \param same  costs that differ by a smaller factor are of
/// one minimum \returns how many minima of different cost they are
std::size_t rankMinima(std::vector<LeastSquaresResult>& found, double same = 1.0001);

/// Residuals at theta, shape (rows).
Eigen::VectorXd residuals(const LeastSquaresProblem& problem, std::span<const double> theta);

/// Sums over some rows, with robust weights W: J^T W J, shape (F, F), and J^T W r, shape (F).
struct NormalSums {
  Eigen::MatrixXd normal;
  Eigen::VectorXd score;
};

/// All that one pass over the rows tells about theta; F free parameters in their order.
struct Linearisation {
  Eigen::VectorXd residual;      ///< shape (rows)
  Eigen::MatrixXd factor;        ///< R of J^T W J = R^T R, shape (F, F)
  std::vector<NormalSums> sums;  ///< of each piece
};

/// \param pieces  of rows, in order, that cover all.
Linearisation linearise(const LeastSquaresProblem& problem, std::span<const double> theta,
                        std::span<const Block> pieces);

/// True when a value sits on one of its bounds, to 1e-6 of its size or of the bounds' distance: on a bound of 0 without
/// another that is 0 itself. Units do not matter.
bool atBound(const ParameterSpec& parameter, double value);

/// Fills `jacobian` by central differences of `residual_at`; for models that are simulated.
/// \param parameters  give bounds (a one-sided difference is taken there) and which are fixed (0).
/// \param typical  shape (P): sizes at which the parameters matter, for steps of those that may be 0.
void differentiateNumerically(
    std::span<const ParameterSpec> parameters, std::span<const double> theta, std::span<const double> typical,
    const std::function<void(std::span<const double>, Eigen::Ref<Eigen::VectorXd>)>& residual_at,
    Eigen::Ref<Eigen::MatrixXd> jacobian);

}  // namespace simgap
