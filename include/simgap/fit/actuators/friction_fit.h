/// \file
/// Fits friction laws to the log of a drive (003 section 4):
///
///     effort = (load + tau_fr(theta)) / k_a + I_0          cost: mean squared error of the effort (003 eq. 16)
///
/// or, to predict torque, load = k_a effort - tau_fr + tau_0 with friction that grows with the motor's torque. For
/// given (v_s, delta) the model is linear in the parameters times 1/k_a; the rows enter the search only through their
/// sums in bins of speed (StribeckMoments), the result is polished on all rows.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "simgap/measure/logs/friction_rows.h"
#include "simgap/model/friction/friction_law.h"
#include "simgap/optimize/least_squares.h"
#include "simgap/optimize/separable.h"
#include "simgap/optimize/uncertainty.h"

namespace simgap {

struct Bounds {
  double lower;
  double upper;
};

struct FrictionFitOptions {
  std::map<std::string, double> fixed;   ///< parameter -> value
  std::map<std::string, Bounds> bounds;  ///< instead of the defaults
  bool offset = false;                   ///< fit I_0 (or tau_0) too
  bool predict_load = false;             ///< fit the torque instead of the effort
  LossKind loss = LossKind::kSquares;
  double loss_scale = 2.0;  ///< in robust standard deviations of the residual
  int folds = 5;            ///< of the cross-validation over blocks; below 2: none
};

/// One law fitted to one log.
struct FrictionFit {
  const FrictionLaw* law = nullptr;
  bool predict_load = false;
  std::vector<double> theta;  ///< shape (P): k_a, the law's terms, the rig's constants, offset, v_s, delta
  Uncertainty uncertainty;
  double mse = 0.0;  ///< of the effort (or the load), on the rows that were fitted
  std::optional<double> mse_heldout;
  std::size_t n = 0;
  std::size_t parameters = 0;  ///< that were fitted
  double bic = 0.0;            ///< set by compareFits
  std::size_t starts = 0;
  std::vector<SeparableMinimum> minima;
  CostProfile profile;  ///< cost over (v_s, delta); empty for laws without them
  std::vector<std::string> warnings;

  double value(std::string_view name) const;
};

/// The least-squares problem of a law on a log: parameters with units and bounds, residuals (predicted - measured) and
/// their derivatives. `data` must outlive it.
LeastSquaresProblem makeFrictionProblem(const FrictionLaw& law, const FrictionData& data,
                                        const FrictionFitOptions& options);

/// Searches the whole box of (v_s, delta), solves for the rest, polishes on all rows.
/// \throws DataError: fewer rows than parameters, k_a or load-dependent terms that the log cannot determine;
///         NumericsError: a channel of the wrong sign, a parameter without a bound;
///         ConfigError: a fixed or bounded parameter the law does not have.
FrictionFit fitFriction(const FrictionLaw& law, const FrictionData& data, const FrictionFitOptions& options);

/// Mean squared error of a fit on other rows.
double meanSquaredError(const FrictionFit& fit, const FrictionData& data, const FrictionFitOptions& options);

/// What the model predicts for some rows, shape (rows.size()). \param problem  that makeFrictionProblem made of `data`:
/// once for all blocks of rows, because that takes a look at every row.
Eigen::ArrayXd predictEffort(const LeastSquaresProblem& problem, const FrictionFit& fit, const FrictionData& data,
                             const FrictionFitOptions& options, const Block& rows);
/// The same for rows that are asked for once.
Eigen::ArrayXd predictEffort(const FrictionFit& fit, const FrictionData& data, const FrictionFitOptions& options,
                             const Block& rows);

/// Sets the BIC of all fits from one effective sample size: n_eff ln(mse) + k ln(n_eff). \returns index of the lowest.
std::size_t compareFits(std::vector<FrictionFit>& fits);

}  // namespace simgap
