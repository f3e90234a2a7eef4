/// \file
/// What a model of an arm gets wrong on recorded poses, and what causes it (docs/diagnose.md). Every effect of
/// the catalogue, on every target, refits the whole model; causes are taken one after the other as long as the evidence
/// for one more is clear, and their gain is measured on poses that took no part in any of that.
#pragma once

#include <string>
#include <vector>

#include "simgap/diagnose/diagnosis.h"
#include "simgap/fit/poses/pose_noise.h"
#include "simgap/measure/pose_set.h"
#include "simgap/model/arm/parameter_space.h"

namespace simgap {

struct PoseDiagnosisOptions : DiagnosisOptions {
  std::size_t max_causes = 8;
  double holdout = 0.25;  ///< fraction of the poses that only measure the gain
  int starts = 8;         ///< of the fit without causes
  int self_test = 0;      ///< sets simulated per effect
  int threads = 0;        ///< 0: all
  /// \throws ConfigError: an effect that is unknown or needs motions, a level or a fraction outside (0, 1)
  void validate() const;
};

/// A model of the arm that the poses leave possible, or had to be asked about.
struct CandidateModel {
  std::string causes;  ///< "payload:forearm, gravity-tilt"; "none"
  std::string role;    ///< "named", "instead" (another cause in the place of a named one), "without", "refused"
  double log_odds;     ///< of the poses without a fault, against the first candidate
  ArmModel model;      ///< fitted to them
  double stray_friction;
};

struct PoseDiagnosis {
  Diagnosis diagnosis;
  std::vector<CandidateModel> candidates;  ///< the extended model first
  std::vector<std::string> used;           ///< names of the poses without a fault
  double excess = 0.0;      ///< of the error on unseen poses over what the extended model expects, a fraction
  ArmModel model;           ///< with the causes, fitted to all poses without a fault
  std::string pose_errors;  ///< CSV: root mean square joint error of each pose before and after [deg]
};

/// \throws DataError: so few different poses that, without those held out, fewer than 8 are left.
void requireEnough(const PoseSet& set, const PoseDiagnosisOptions& options);

/// \param parameters  the ordinary parameters that every hypothesis refits, with their priors
/// \throws DataError: as requireEnough.  NumericsError: no parameters give every pose an equilibrium.
PoseDiagnosis diagnosePoses(const ArmModel& model, const PoseSet& set,
                            const std::vector<ParameterSpace::Choice>& parameters, const PoseNoise& noise,
                            const PoseDiagnosisOptions& options, const DiagnosisProgress& progress);

}  // namespace simgap
