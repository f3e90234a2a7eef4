/// \file
/// What poses after a change say of a candidate when all that the poses before left open of it is weighed: the integral
/// of the posterior over the parameters, by Laplace's approximation about the optimum of both together,
///
///   Phi(z, u) = Phi_before(z) + 1/2 |e(z) + G u|^2 + 1/2 |u|^2
///   log p(after | before) = Phi_before(z0) - Phi(z*, u*) + 1/2 log |N_before(z0)| - 1/2 log |N(z*, u*)|
///
/// e: whitened distances of predicted from measured poses, u: the change's uncertain numbers in standard deviations, G:
/// their effect, N: curvatures. Where e is linear in z, 2 (Phi(z*) - Phi_before(z0)) is e^T S^-1 e of
/// pose_intervention.h; where a change moves the arm further than derivatives reach, only this holds.
#pragma once

#include "pose_prediction.h"

namespace simgap {

struct Weighed {
  double distance = 0.0;        ///< 2 (Phi(z*, u*) - Phi_before(z0)), chi^2 of the after poses' components
  double log_likelihood = 0.0;  ///< up to a constant that all candidates share
};

/// \param after  poses that the candidate is judged by \param uncertain  G, shape (components of all of them, numbers);
/// empty: no number of the change is uncertain
Weighed weighAfter(const PoseEvidence& evidence, const CandidateModel& candidate, const ArmChanges& change,
                   std::span<const Pose> after, const Eigen::MatrixXd& uncertain = {});

}  // namespace simgap
