/// \file
/// What the poses tell and what they cannot: Laplace's approximation of the posterior about a fit, with the
/// Gauss-Newton curvature N = sum_p w_p J_p^T J_p + P. w_p: robust weight, P: 1 for each parameter with a prior.
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "simgap/fit/poses/pose_posterior.h"

namespace simgap {

enum class Verdict {
  kIdentifiable,     ///< the poses at least halve the standard deviation of the hand measurement
  kWeak,             ///< they tell something; more poses could tell more
  kNotIdentifiable,  ///< they tell nothing, or no number of poses could halve it: only a combination with others is
                     ///< known
};
std::string_view toString(Verdict verdict);
/// A posterior standard deviation that is this share of the prior's, or less, makes a parameter identifiable.
inline constexpr double kHalvedPrior = 0.5;
/// By a posterior standard deviation as a share of the prior's; 0 for a parameter without one.
Verdict verdictOfShare(double of_prior);

struct ParameterUncertainty {
  double prior_sd;  ///< of the hand measurement, in the parameter's unit; infinite without one
  double sd;        ///< of the posterior; infinite when nothing bounds it
  Verdict verdict;
};

/// Parameters of which only a combination can be known.
struct Combination {
  std::vector<std::size_t> parameters;  ///< indices
  bool always;                          ///< true: for any pose of the arm, false: for the recorded ones
  std::string text;                     ///< "kite_line_length_m and shock_cord.rest_length_m of biceps: only their sum"
};

/// Laplace's approximation says nothing of parameters farther than this from the most probable ones [sd].
inline constexpr double kAtOptimum = 1.0;

struct PoseUncertainty {
  Eigen::MatrixXd covariance;           ///< of z, shape (parameters, parameters)
  std::vector<double> singular_values;  ///< of the whitened Jacobian, in prior standard deviations, descending
  std::vector<ParameterUncertainty> parameters;
  std::vector<Combination> combinations;
  /// Length of the Newton step to the most probable parameters, in standard deviations: sqrt(g^T N^-1 g) with the
  /// gradient g of the negative log posterior; beyond kAtOptimum no more than what the way along that step gains says,
  /// as slopes do not vanish at a kink. Far above 0, nothing else here holds.
  double from_optimum = 0.0;
  std::vector<double>
      distances;  ///< d_p of each pose; NaN without an equilibrium; beyond kRobustScale it is an outlier
};

/// \throws NumericsError when no pose has a stable equilibrium at z.
PoseUncertainty assessUncertainty(PosePosterior& posterior, const Eigen::VectorXd& z, const ParameterSpace& space);

/// Mean joint error that the posterior predicts for poses, if the model's structure is right: parameters, joint
/// friction and capture noise drawn anew.
struct PredictedError {
  std::vector<double> mean, lower, upper;  ///< shape (joints) [rad]; 5 % and 95 % quantiles of a set of that size
};

/// \param uncertainty  of the fit at z  \param poses  their shafts and measured joints (equilibria start there)
/// \returns nothing (no joints) when none of the poses has an equilibrium at z
PredictedError predictError(const PosePosterior& posterior, const Eigen::VectorXd& z,
                            const PoseUncertainty& uncertainty, std::span<const Pose> poses);

/// Commands like the recorded ones (each shaft within its recorded range) that lead to stable equilibria of the model
/// at z, with their equilibrium as joints, and pull no line harder than `most_tension` [N]. A pure function of its
/// arguments.
std::vector<Pose> drawCommands(const PosePosterior& posterior, const Eigen::VectorXd& z, std::size_t count,
                               std::uint64_t seed, double most_tension = kInfinity);

}  // namespace simgap
