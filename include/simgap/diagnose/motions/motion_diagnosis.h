/// \file
/// What a model of an arm gets wrong while it moves, and what causes it (docs/diagnose-motions.md). Every effect of the
/// catalogue that acts over seconds, on every target, is scanned by rollouts; the best are refitted with all
/// parameters; a cause is named only if motions that took no part in any of that are missed by less with it.
#pragma once

#include <string>
#include <vector>

#include "simgap/diagnose/diagnosis.h"
#include "simgap/fit/motions/motion_calibration.h"
#include "simgap/measure/motion_noise.h"

namespace simgap {

struct MotionDiagnosisOptions : DiagnosisOptions {
  std::size_t max_causes = 2;
  double holdout = 0.3;  ///< fraction of the motions that only measure the gain, without a set of their own
  /// \throws ConfigError: an unknown effect, a level or a fraction outside (0, 1)
  void validate() const;
};

/// What one motion says.
struct MotionSay {
  std::string motion;
  bool held_out;
  double before, after;  ///< mean square of its residuals, in variances of the noise
  double evidence;       ///< its part of the evidence for the causes; of held-out ones NaN
  std::string worst;     ///< "elbow at 3.2 s": where it is missed most with the causes
};

/// A model that a diagnosis left standing or refused, with what is known of its parameters.
struct MotionCandidate {
  std::string causes;               ///< "payload:forearm, guide-friction"; "none"
  std::string role;                 ///< as of pose sets (pose_diagnosis.h)
  double log_odds = 0.0;            ///< of the motions that select, against the first candidate
  double capture_delay = 0.0;       ///< [s]
  ArmModel model = {};              ///< fitted to them
  Eigen::MatrixXd covariance = {};  ///< of z (motion_posterior.h) beside its place
};

/// How motions are missed that no change was made to: what motions after a change are compared with.
struct MotionReference {
  double variance = 1.0;        ///< mean square of held-out residuals with the named model, in noise variances, >= 1
  double mean = 0.0, sd = 0.0;  ///< over motions, of the logarithm of their mean squares
  int motions = 0;
  double way = 1.0;  ///< mean square of how far parameters have to go to held-out ones, in what is said of them; >= 1
};

struct MotionDiagnosis {
  Diagnosis diagnosis;
  std::vector<MotionCandidate> candidates;  ///< the extended model first; one alone: nothing to compare it with
  MotionReference reference;
  MotionNoise noise;
  std::vector<RecordedMotion> profile;  ///< a few of those that select, to foresee motions with
  std::vector<MotionSay> motions;
  ArmModel model;                           ///< with the causes
  ArmModel baseline;                        ///< without, fitted to the same motions
  MotionSet held_out;                       ///< by which it was judged
  std::vector<PlayedMotion> before, after;  ///< of these
  PoseLayout layout;
  long rollouts = 0;
};

/// \param held_out  given: those judge, and all of `motions` select; else a fraction of `motions`
/// \throws DataError: fewer than 4 motions to select with or 3 to judge by. NumericsError: the motions cannot be played
MotionDiagnosis diagnoseMotions(const ArmModel& model, const MotionSet& motions, const MotionSet* held_out,
                                const MotionCalibrationConfig& config, const MotionDiagnosisOptions& options,
                                const DiagnosisProgress& progress);

}  // namespace simgap
