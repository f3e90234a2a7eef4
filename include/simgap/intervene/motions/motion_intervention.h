/// \file
/// A change of the arm that was made on purpose tells causes apart that fit the same motions: every candidate of a
/// diagnosis plays the motions after it with nothing refitted, and comes as near to them as its own uncertainty x lets
/// it (src/diagnose/motions/candidate_motions.h). Two things must be as they were: what is left at that x (as much as
/// of motions before, Student's t over motions), and how far x had to go, beside how far it had to for held-out motions
/// before (Fisher's F); p is the smaller of both, twice.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "simgap/diagnose/motions/motion_diagnosis.h"
#include "simgap/intervene/intervention.h"
#include "simgap/model/arm/arm_change.h"

namespace simgap {

/// What one motion asks of the muscles.
struct PlannedMotion {
  std::string name;
  MotionCommands commands;
};

/// What a diagnosis of motions knew.
struct MotionEvidence {
  ArmModel given;  ///< the model that was diagnosed
  MotionCalibrationConfig config;
  std::vector<MotionCandidate> candidates;  ///< the named one first
  MotionReference reference;
  MotionNoise noise;
  std::vector<PlannedMotion> profile;  ///< a few of the motions before the change

  /// \throws ConfigError: a covariance of another number of parameters than its candidate has
  void validate() const;
  /// \throws ConfigError: a change takes away what no candidate holds
  void require(const ArmChanges& change) const;
  std::vector<bool> rivals() const;  ///< of the named one, as rivalsOf
};

/// What one candidate said of the motions after the change.
struct PlayedCandidate {
  Eigen::MatrixXd
      squares;          ///< mean squares of its residuals, shape (joints + shafts + currents, motions); NaN: not played
  double rms = 0.0;     ///< root of their mean [noise sd]
  double left = 0.0;    ///< root of the mean square that is left at the best x [noise sd]
  double p_left = 0.0;  ///< of as much left there, were the candidate right
  double p_way = 0.0;   ///< of as far a way to x
  double p = 0.0;       ///< the smaller of both, twice
  double log_odds = 0.0;  ///< against the named candidate, from the motions after the change alone
  std::size_t lost = 0;   ///< motions that it cannot play
};

struct MotionIntervention {
  InterventionVerdict verdict = InterventionVerdict::kCannotTell;  ///< on the named candidate
  std::string sentence;
  std::vector<PlayedCandidate> predictions;  ///< shape (candidates)
};

/// Called with the part that is done.
using InterventionProgress = std::function<void(double done)>;

/// Motions after a change judge the candidates. \throws ConfigError: a model that cannot be changed so.
/// DataError: no candidate can play any of the motions. InterruptedError
MotionIntervention judgeChange(const MotionEvidence& evidence, const ArmChanges& change, const MotionSet& after,
                               const InterventionProgress& progress);

/// What a change, or other commands, would tell.
/// \param planned  to record after the change
ForeseenChange foreseeChange(const MotionEvidence& evidence, const ArmChanges& change,
                             const std::vector<PlannedMotion>& planned, const InterventionProgress& progress);

}  // namespace simgap
