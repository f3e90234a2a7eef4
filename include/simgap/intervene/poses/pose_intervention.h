/// \file
/// A change of the arm that was made on purpose tells causes apart that fit the same poses: every candidate of a
/// diagnosis predicts the poses after it with nothing refitted,
///
///     S = 1 + J N^-1 J^T + sum_k g_k g_k^T
///
/// e: the whitened distances of predicted from measured poses (pose_posterior.h), J: their derivatives by the
/// parameters, N: the curvature of the posterior before the change, g_k: what one standard deviation of an uncertain
/// number of the change does. S is scaled by what the diagnosis left unexplained on poses it had not seen, and its size
/// is known from the poses before alone: distances follow Fisher's F.
#pragma once

#include <string>
#include <vector>

#include "simgap/diagnose/poses/pose_diagnosis.h"
#include "simgap/intervene/intervention.h"
#include "simgap/model/arm/arm_change.h"

namespace simgap {

/// What a diagnosis knew: enough to find the posterior of each of its candidates again.
struct PoseEvidence {
  ArmModel given;                                  ///< the model that was diagnosed
  std::vector<ParameterSpace::Choice> parameters;  ///< ordinary ones, with their priors
  PoseNoise noise;
  std::vector<Pose> poses;                 ///< before the change, those without a fault
  std::vector<CandidateModel> candidates;  ///< the named one first
  double excess = 0.0;  ///< of the squared error on unseen poses over what the named model expects, a fraction
  int threads = 0;      ///< 0: all
};

/// What one candidate said of the poses after the change.
struct CandidatePrediction {
  double rms = 0.0;                     ///< [deg] of the joints' errors
  double distance = 0.0;                ///< e^T S^-1 e
  int freedom = 0;                      ///< components of e
  double p = 0.0;                       ///< of a distance as large, were the candidate right
  double log_odds_before = 0.0;         ///< against the named candidate, from the poses before
  double log_odds = 0.0;                ///< the same from the poses after the change alone
  std::size_t without_equilibrium = 0;  ///< poses
  std::vector<double> errors;           ///< shape (poses, joints) [deg], or [mm] of a slide
};

struct Intervention {
  InterventionVerdict verdict = InterventionVerdict::kCannotTell;  ///< on the named candidate
  std::string sentence;
  std::vector<CandidatePrediction> predictions;  ///< shape (candidates)
  std::vector<std::string> poses;                ///< that were compared
  std::vector<std::string> left_out;             ///< poses that no candidate comes near: outliers
};

/// Poses after a change judge the candidates. \throws ConfigError: a model that cannot be changed so.
/// DataError: no pose that any candidate comes near.
Intervention judgeChange(const PoseEvidence& evidence, const ArmChanges& change, const PoseSet& after);

/// Were the arm to be recorded again at the same shafts.
ForeseenChange foreseeChange(const PoseEvidence& evidence, const ArmChanges& change);

}  // namespace simgap
