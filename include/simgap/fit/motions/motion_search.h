/// \file
/// The most probable parameters of recorded motions by Levenberg-Marquardt on rollouts.
///
/// Derivatives by differences cost one rollout per parameter and motion, a step only one per motion. So they are kept
/// from step to step and corrected by what each step taught (Broyden 1965), J += (dr - J dz) dz^T / |dz|^2, and made
/// anew when that no longer helps; the end is where steps with fresh derivatives gain nothing. Its first rounds compare
/// an eighth, a quarter and a half of every motion (multiple shooting's reason, without its many beginnings: errors of
/// a wrong model pile up along a motion), and its loss is as wide as most residuals are.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/fit/motions/motion_posterior.h"

namespace simgap {

/// One round: derivatives made anew and the steps taken with them; a row of history.csv.
struct MotionRound {
  int round = 0;                     ///< from 1
  double before = 0.0, after = 0.0;  ///< negative log posterior
  int steps = 0;                     ///< accepted
  long rollouts = 0;                 ///< motions played since the start
  double expected = 0.0;             ///< gain that the last derivatives still promise
  double horizon = 1.0;              ///< share of every motion that it compared
};

/// From where a search goes on, to the bit: it is stored after every round.
struct MotionSearchState {
  Eigen::VectorXd z;
  Eigen::VectorXd steps;  ///< of the differences, in z
  double damping = 1e-3;
  std::vector<MotionRound> history;
  bool converged = false;
  double wall = 0.0;  ///< [s] in all sessions
};
Json toJson(const MotionSearchState& state);
/// \throws ConfigError when it is no such state of so many parameters
MotionSearchState motionSearchStateFromJson(const Json& json, Eigen::Index parameters);

/// The state every search begins with.
MotionSearchState beginSearch(const MotionPosterior& posterior);

/// What was found, with its curvature. Derivatives are means of differences forwards and backwards there. Stick and
/// slip make residuals jump, and jumps leave noise in differences, which would pass for information along directions of
/// which the motions tell nothing. Fourth differences, from half steps as well, say how large it is: a response that is
/// smooth, however bent, leaves next to nothing in them. It is taken out of the curvature, and the derivatives given
/// are the best linear estimates of those without it: a direction that only noise tells has none, and no scores either.
struct MotionFit {
  Eigen::VectorXd z;
  double objective = 0.0;
  Eigen::MatrixXd covariance;        ///< of z
  std::vector<RowMajorF> jacobians;  ///< shape (motions), of whitened residuals
  Eigen::VectorXd step_left;         ///< the Newton step left, in z, shape (size of z)
  double from_optimum = 0.0;         ///< its length [sd]
};

/// What to show while it searches.
struct MotionSearchNews {
  std::size_t rollouts;  ///< in this round
  std::size_t of;
};

/// \name Parts of a search, for those who choose when derivatives are made anew
///@{
/// Residuals and derivatives, and where they stand.
struct MotionLinearisation {
  Eigen::VectorXd z;
  MotionEvaluation at;
  std::vector<RowMajorF> jacobians;  ///< shape (motions)
};
/// \throws NumericsError: the motions cannot be played with these parameters; InterruptedError
MotionLinearisation linearise(const MotionPosterior& posterior, const Eigen::VectorXd& z, const Eigen::VectorXd& steps,
                              const std::function<void(const MotionSearchNews&)>& news);
/// Marquardt's steps with one set of derivatives, which each corrects, until it promises little more.
/// \param[in,out] rollouts  counts them  \returns how many steps were accepted  \throws InterruptedError
int descend(const MotionPosterior& posterior, MotionLinearisation& here, double& damping, long& rollouts);
/// Derivatives made anew where it counts: along the directions of z of which these motions tell more than the prior
/// does, each a rollout of every motion; as Broyden's update, J += (dR - J dZ) (dZ^T dZ)^-1 dZ^T, by all of them at
/// once. Along the others, half of a large arm's, the prior decides, and old derivatives are as good. \returns how many
/// rollouts that took  \throws InterruptedError
long renew(const MotionPosterior& posterior, MotionLinearisation& here,
           const std::function<void(const MotionSearchNews&)>& news);
/// Inverse of the curvature at `here`.
Eigen::MatrixXd covarianceAt(const MotionPosterior& posterior, const MotionLinearisation& here);
/// The Newton step left at `here`, within the bounds, shape (size of z).
Eigen::VectorXd stepLeftAt(const MotionPosterior& posterior, const MotionLinearisation& here);
///@}

/// Mean square of errors in units of what is expected of them.
double meanSquareOf(const MotionPosterior& posterior, const MotionEvaluation& at);
/// Standard deviations of z, shape (size of z): Laplace's, wider where the model misses by more than expected and where
/// what it misses lasts, with the step left where a search ended before its end. The prior bounds what is known,
/// however badly the model fits. \param jacobians  shape (motions) \param covariance  Laplace's, of z \param step_left
/// in z
Eigen::VectorXd deviationsOf(const MotionPosterior& posterior, const MotionEvaluation& at,
                             const std::vector<RowMajorF>& jacobians, const Eigen::MatrixXd& covariance,
                             const Eigen::VectorXd& step_left);

/// A loss as wide as most residuals are: what is far off counts until it is near, then outliers count little again.
/// \param[in,out] at  what the motions are at z, whose objective becomes that of this loss
void fitRobustScale(MotionPosterior& posterior, const Eigen::VectorXd& z, MotionEvaluation& at);

/// Searches to the end, or for `max_rounds`. \param after_round  to store the state
/// \throws NumericsError: the motions cannot be played with the parameters it begins with; InterruptedError
MotionFit searchMotions(MotionPosterior& posterior, MotionSearchState& state, int max_rounds,
                        const std::function<void(const MotionSearchNews&)>& news,
                        const std::function<void(const MotionSearchState&)>& after_round);

/// Derivatives and covariance at z, without a search. \param steps  of the differences
MotionFit fitAt(const MotionPosterior& posterior, const Eigen::VectorXd& z, const Eigen::VectorXd& steps,
                const std::function<void(const MotionSearchNews&)>& news);

}  // namespace simgap
