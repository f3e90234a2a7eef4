/// \file
/// How much of the joints' friction points anywhere is not known beforehand: an arm that is wound slowly lags on one
/// side.
#pragma once

#include "pose_fit.h"

namespace simgap {

/// A fit whitened anew with its own solution and the stray friction that makes the poses most probable.
/// \param problem  begins with its stray friction, ends with the found one
/// \param poses  must outlive the fit
PoseFit settledFit(PoseProblem& problem, std::span<const Pose> poses, const std::vector<ArmCause>& causes,
                   const Eigen::VectorXd& z);

}  // namespace simgap
