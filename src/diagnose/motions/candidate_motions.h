/// \file
/// What one candidate of a diagnosis says of motions that it was not fitted to, before or after a change of the arm,
/// with nothing refitted. With e: its whitened residuals (motion_residuals.h), and G x: what its own uncertainty moves
/// them by, x ~ N(0, 1) along the square root of its parameters' covariance and along each uncertain number of the
/// change,
///
///     -2 ln p = min_x ( sum_w rho(|e_w + G_w x|^2) / s^2 + |x|^2 ) + ln|1 + G^T W G / s^2|
///
/// (Laplace's approximation), s^2: by how much held-out motions before the change are missed by more than noise.
#pragma once

#include <memory>
#include <span>
#include <vector>

#include "motion_fit.h"
#include "simgap/diagnose/motions/motion_diagnosis.h"
#include "simgap/model/arm/arm_change.h"

namespace simgap {

struct PredictedMotions {
  std::unique_ptr<MotionPosterior> posterior;  ///< of the motions after the change
  std::vector<Eigen::VectorXd> e;  ///< shape (motions) of (numbers), whitened; empty: the motion cannot be played
  std::vector<RowMajorF> moves;    ///< G, shape (motions) of (numbers, directions)
  Eigen::Index directions = 0;
};

/// \param motions  must outlive what is returned
PredictedMotions predictMotions(const MotionProblem& problem, const MotionCandidate& candidate,
                                const ArmChanges& change, std::span<const RecordedMotion> motions);

/// How far x went: along the axes of which the motions say something it has covariance a / (1 + a), and the mean of its
/// squares in these is 1 where the parameters are known as well as is said.
struct Way {
  double ratio = 0.0, axes = 0.0;
};

/// Where x comes to rest, and what it says.
struct Explained {
  double log_likelihood = 0.0;
  std::vector<Eigen::VectorXd> left;  ///< shape (motions) of (numbers), as PredictedMotions::e
  Way way;
};

/// The least that a candidate misses by within its own uncertainty: weights of the robust loss and x in turn.
/// \param variance  of the residuals, by which held-out motions are missed
Explained explain(const PredictedMotions& predicted, double variance);

/// d^T (s^2 + G G^T)^-1 d / 2 by the matrix inversion lemma: what a distance of two predictions is worth.
double worthOf(const PredictedMotions& right, const PredictedMotions& wrong, double variance);

/// How far a candidate's parameters have to go to motions that no fit has seen: the mean square of it, 1 where they are
/// known as well as is said.
double wayOf(const MotionProblem& problem, const MotionCandidate& candidate, std::span<const RecordedMotion> motions,
             double variance);

}  // namespace simgap
