/// \file
/// How well a fit does on motions that took no part in it.
#pragma once

#include "motion_fit.h"
#include "simgap/diagnose/diagnosis.h"

namespace simgap {

/// The motions that select and those that judge.
struct MotionSplit {
  MotionSet selecting, judging;
};
/// \param held_out  null: a fraction of the motions judges
MotionSplit splitMotions(const MotionSet& motions, const MotionSet* held_out, double fraction);

/// Mean squares of the whitened residuals, each joint, the shafts and the currents counting alike: in one sum the many
/// channels of drives would drown the joints. Shape (groups, motions); NaN: not measured.
Eigen::MatrixXd groupSquares(const MotionPosterior& posterior, const MotionEvaluation& at);
/// What noise alone makes of them: less than 1, as a channel may miss by the discrepancy, too.
Eigen::MatrixXd noiseSquares(const MotionPosterior& posterior);
/// The same of other motions played with the fit's model at z; NaN where one cannot be played.
Eigen::MatrixXd unseenSquares(const MotionCauseFit& fit, const Eigen::VectorXd& z, const MotionProblem& problem,
                              std::span<const RecordedMotion> motions);

/// The most by which parameters that are drawn from what is known of them move other motions: the largest of the means
/// over motions, as groupSquares, shape (groups). So much the right model may miss where parameters are hardly known.
Eigen::VectorXd unknownSquares(const MotionCauseFit& fit, const MotionProblem& problem,
                               std::span<const RecordedMotion> motions);
/// Whether a group is missed by more than noise and unknown parameters leave. What the fitted motions are missed by,
/// too, no parameter excuses: the fit was free to set it. \param missed, fitted  mean squares of held-out motions and
/// of those that were fitted \param unknown  as unknownSquares
bool isLeft(double missed, double fitted, double unknown);

/// By how much less `after` misses than `before`, of each motion: the mean logarithm of the groups' ratios. A motion
/// that only one can play counts for that one. Motions that neither misses by more than noise and discrepancy leave say
/// nothing of what is missing: where at least three others do, these alone are given.
Eigen::ArrayXd logGains(const Eigen::MatrixXd& before, const Eigen::MatrixXd& after);
/// Its mean as a fraction of the mean square, with a 95 % interval by Student's t over motions.
Interval gainOf(const Eigen::ArrayXd& log_gains);
/// The same of two fits. Where `before` surely misses something that `after` misses in no motion and each gains,
/// motions differ in how much of the cause they show and not in whether it is there: Student's t, that takes the one
/// for the other, is then of the logarithms of explained : left.
Interval heldOutGain(const Eigen::MatrixXd& before, const Eigen::MatrixXd& after);
/// How probable as large a mean is where nothing was gained.
double chanceOfGain(const Eigen::ArrayXd& log_gains);
/// Of what a motion is missed by beyond the noise, the share that `after` does not miss: the median over motions, as
/// one that falls to the other side of its rest would outweigh all others. \param before, after  as groupSquares
/// \param floor  shape (motions): the mean square that no cause takes away
double explainedShare(const Eigen::MatrixXd& before, const Eigen::MatrixXd& after, const Eigen::ArrayXd& floor);
/// Mean over groups and motions; what cannot be played left out.
double meanSquare(const Eigen::MatrixXd& squares);

}  // namespace simgap
