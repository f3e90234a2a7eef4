/// \file
/// The models that a diagnosis leaves standing or has refused, for a change of the arm to choose from
/// (pose_intervention.h).
#pragma once

#include "pose_selection.h"

namespace simgap {

/// The extended model, each cause replaced by what else fitted well there, what was refused at last, and the model
/// without causes; all fitted to the same poses.
/// \param plain, fit  at their solutions
std::vector<CandidateModel> candidateModels(const PoseProblem& problem, PoseFit& plain, double stray_plain,
                                            PoseFit& fit, const PoseSelection& selection);

/// Takes out of every cause's rivals, and out of the candidates, what was named itself since, in the place of another
/// cause or beside it.
void dropNamedRivals(PoseSelection& selection);

}  // namespace simgap
