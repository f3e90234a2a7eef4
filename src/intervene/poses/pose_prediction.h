/// \file
/// What a candidate of a diagnosis predicts for poses after a change of the arm, and how surely (pose_intervention.h).
#pragma once

#include <Eigen/Cholesky>
#include <cstdint>
#include <optional>
#include <span>
#include <vector>

#include "diagnose/poses/pose_fit.h"
#include "simgap/intervene/poses/pose_intervention.h"

namespace simgap {

inline constexpr double kOutOfReach = 10.0;  ///< [sd] per component, of a pose that the candidate cannot take

/// Poses as a candidate predicts them after a change.
struct Predicted {
  std::vector<bool> valid;                 ///< shape (poses)
  std::vector<Eigen::VectorXd> raw;        ///< shape (poses) of (dof): predicted less measured [rad], [m]
  std::vector<Eigen::MatrixXd> whitening;  ///< shape (poses) of (dof, dof)
  Eigen::MatrixXd spread;                  ///< J L^-T, shape (n, parameters): what the parameters leave open of e
  Eigen::MatrixXd uncertain;               ///< g_k in columns, shape (n, uncertain numbers of the change)
  Eigen::VectorXd e;                       ///< shape (n): whitened, of all poses
  Eigen::MatrixXd covariance;              ///< S, shape (n, n)
  double known = 1.0;                      ///< nu: degrees of freedom that the poses before leave for the size of S
  Eigen::Index dof = 0;
};

/// The fitted numbers of a model with these causes, in the scale of a fit.
Eigen::VectorXd solutionOf(PoseFit& fit, const ArmModel& model);
/// Indices of the parameters of causes that a change takes away.
std::vector<Eigen::Index> undoneParameters(const PoseFit& fit, const ArmChanges& change);
PoseProblem problemOf(const PoseEvidence& evidence, const CandidateModel& candidate);

class PosePrediction {
 public:
  /// Both must outlive it.
  PosePrediction(const PoseEvidence& evidence, const CandidateModel& candidate);
  Predicted after(const ArmChanges& change, std::span<const Pose> poses) const;
  /// Commands as an arm that this candidate describes would be recorded at them: what is left open of its parameters,
  /// friction and noise are drawn. \returns none where a pose has no equilibrium then
  std::optional<std::vector<Pose>> recorded(std::span<const Pose> commands, std::uint64_t seed,
                                            std::uint32_t draw) const;
  /// The candidate's own posterior on some poses, with its solution in the scale of a fit.
  template <class Action>
  auto atPosterior(std::span<const Pose> poses, const Action& action) const {
    PoseFit fit(problemOf(evidence_, candidate_), poses, causes_);
    const Eigen::VectorXd z = solutionOf(fit, candidate_.model);
    fit.posterior().whiten(z);
    return action(fit.posterior(), z);
  }

 private:
  void learnPosterior();
  Predicted predict(const ArmChanges& change, std::span<const Pose> poses, bool jacobians,
                    const Predicted* like = nullptr) const;

  const PoseEvidence& evidence_;
  const CandidateModel& candidate_;
  std::vector<ArmCause> causes_;
  Eigen::LLT<Eigen::MatrixXd> curvature_;  ///< N = L L^T
  double known_ = 1.0;                     ///< residuals before the change, less the parameters they determine
};

}  // namespace simgap
