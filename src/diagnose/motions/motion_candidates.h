/// \file
/// The models that a diagnosis of motions keeps, for a change of the arm to judge.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "motion_fit.h"
#include "simgap/diagnose/motions/motion_diagnosis.h"

namespace simgap {

/// What all fits of a diagnosis share, from what it was asked with; `motions` are still to be set.
MotionProblem motionProblem(const ArmModel& model, const MotionCalibrationConfig& config);

/// The usual time between two rows, of the motion with the longest: when a command changed is known to no less [s].
double usualRow(std::span<const RecordedMotion> motions);

/// A fit as it stands. Its log odds are its negative log posterior, until all are compared.
MotionCandidate candidateOf(const MotionCauseFit& fit, const char* role);
/// Log odds against the first one. \param variance  of the residuals, in which negative log posteriors count
void compareWithFirst(std::vector<MotionCandidate>& candidates, double variance);

/// \param before  as groupSquares, of all motions that were fitted, and of those that were not
MotionReference referenceOf(const Eigen::MatrixXd& fitted, const Eigen::MatrixXd& unseen);
/// Logarithm of each motion's mean square, its groups counting alike; NaN: it cannot be played. Shape (motions)
Eigen::ArrayXd logSquares(const Eigen::MatrixXd& squares);

}  // namespace simgap
