/// \file
/// What one candidate of a diagnosis says of motions after a change of the arm, and what its uncertainty moves it by.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "simgap/diagnose/motions/motion_intervention.h"

namespace simgap {

struct PredictedMotions {
  std::unique_ptr<MotionPosterior> posterior;  ///< of the motions after the change
  std::vector<Eigen::VectorXd> e;  ///< shape (motions) of (numbers), whitened; empty: the motion cannot be played
  std::vector<RowMajorF> moves;    ///< G, shape (motions) of (numbers, directions)
  Eigen::Index directions = 0;
};

/// \param motions  must outlive what is returned
PredictedMotions predictMotions(const MotionEvidence& evidence, const MotionCandidate& candidate,
                                const ArmChanges& change, std::span<const RecordedMotion> motions);

/// How far a candidate's parameters have to go to motions that no fit has seen: the mean square of it, 1 where they are
/// known as well as is said.
double wayOf(const MotionEvidence& evidence, const MotionCandidate& candidate, std::span<const RecordedMotion> motions);

/// The named candidate's own motion under commands, as if it had been recorded without noise.
/// \throws NumericsError: it blows up
RecordedMotion playedAsRecorded(const MotionEvidence& evidence, const ArmChanges& change,
                                const MotionCommands& commands, const std::string& name);

}  // namespace simgap
