/// \file
/// What follows from the causes that poses speak for, and from what is left beside them.
#pragma once

#include "pose_selection.h"
#include "simgap/diagnose/diagnosis.h"

namespace simgap {

/// RMS error of the model with the causes on poses held out, in RMS of the noise. \param noise  [deg^2]
double leftInNoise(const Diagnosis& diagnosis, double noise);

/// Whether what has no name beside the causes is far more than noise, or more than they take away of it: then it may
/// look like them. By cross-validation and by the poses held out. \param noise  [deg^2] that the arm has; friction that
/// grew to cover up for what has no name is none
bool leavesTooMuch(const PoseSelection& selection, const Diagnosis& diagnosis, double noise);

/// Verdict, sentence, and a warning of what is left. \param heldout  poses;  \param partial  causes became candidates
/// since they leave too much
void concludePoses(const PoseSelection& selection, std::size_t heldout, bool partial, Diagnosis& diagnosis);

}  // namespace simgap
