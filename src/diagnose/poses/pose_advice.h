/// \file
/// Which pose to record next so that causes that the poses do not tell apart part.
#pragma once

#include "pose_fit.h"
#include "pose_selection.h"

namespace simgap {

/// In plain words and numbers. \param fit  with the causes, on all poses
std::string nextPoseExperiment(const PoseProblem& problem, PoseFit& fit, const PoseSelection& selection,
                               const std::vector<ArmHypothesis>& hypotheses,
                               const std::vector<NotTestable>& not_testable);

}  // namespace simgap
