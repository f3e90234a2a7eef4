/// \file
/// How often the diagnosis is right on this very design: each effect, and none, is put into the fitted model, the
/// user's own commands are simulated with it, with the noise and the stiction that the fit assumes, and diagnosed anew.
#pragma once

#include "pose_fit.h"
#include "pose_selection.h"

namespace simgap {

/// \param fit  without causes, on all poses, at its solution
SelfTest selfTestPoses(const PoseProblem& problem, PoseFit& fit, const std::vector<ArmHypothesis>& hypotheses,
                       const std::vector<Detectable>& detectable, const PoseDiagnosisOptions& options,
                       const DiagnosisProgress& progress);

}  // namespace simgap
