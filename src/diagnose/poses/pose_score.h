/// \file
/// What a small cause would do to the poses beyond what the ordinary parameters can absorb, from a linearised fit:
/// M = 1 - J N^-1 J^T over the whitened components of all poses, N = J^T J + P. A signature s of unit cause has the
/// information s^T M s; the residual e speaks for s^T e of it (J^T e + P z = 0 at the optimum).
#pragma once

#include "pose_fit.h"
#include "pose_selection.h"
#include "simgap/diagnose/diagnosis.h"

namespace simgap {

class PoseScore {
 public:
  /// \param fit  at its solution
  explicit PoseScore(PoseFit& fit);
  const Eigen::VectorXd& residual() const { return residual_; }  ///< shape (poses * dof), robustly weighted
  /// s^T M s.
  double information(const Eigen::VectorXd& signature) const;
  /// Signatures of the fitted parameters of one more cause at its start: the change of the residual per unit of the
  /// parameter, shape (poses * dof, fitted parameters).
  Eigen::MatrixXd slopes(const PoseProblem& problem, const ArmCause& cause) const;
  /// The change of the residual that a cause makes, shape (poses * dof); jumps are cut.
  Eigen::VectorXd change(const PoseProblem& problem, const ArmCause& cause) const;

 private:
  std::vector<double> roots_;  ///< of the poses' robust weights
  PoseFit& fit_;
  Eigen::VectorXd residual_;
  Eigen::MatrixXd left_;  ///< L^-1 J^T with N = L L^T
};

/// The moments at which a slip of each muscle would explain most, as starts.
void placeMoments(const PoseProblem& problem, PoseFit& fit, std::vector<ArmHypothesis>& hypotheses);

/// The smallest magnitude of each hypothesis, beside the causes of the fit, that these poses would reveal.
std::vector<Detectable> detectableMagnitudes(const PoseProblem& problem, PoseFit& fit,
                                             std::vector<ArmHypothesis> hypotheses);

}  // namespace simgap
