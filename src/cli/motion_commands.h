/// \file
/// `calibrate`, `validate` and `diagnose` with --motions.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "simgap/cli/session.h"
#include "simgap/core/error.h"
#include "simgap/intervene/motions/motion_intervention.h"
#include "simgap/optimize/evolution_strategy.h"

namespace simgap {

/// What the command line says of an evolution in place of the config's.
struct StrategyOptions {
  std::optional<int> generations, mu, lambda;
  std::optional<double> target_fitness;

  /// \throws ConfigError: a population that the optimiser cannot work with
  void applyTo(const std::string& optimizer, const std::optional<std::uint64_t>& seed,
               EvolutionStrategyOptions& strategy) const;
};

struct MotionCalibrateOptions {
  CommonOptions common;
  bool skip_bad_rows = false;
  std::string model, motions, validation_motions, poses, config;
  std::filesystem::path resume;  ///< empty: a new run
  std::optional<std::string> optimizer;
  StrategyOptions strategy;
};
ExitCode calibrateMotions(const MotionCalibrateOptions& options, const std::vector<std::string>& argv);
/// Whether a directory holds a calibration on motions, to be resumed by calibrateMotions().
bool holdsMotionCalibration(const std::filesystem::path& directory);

struct MotionValidateOptions {
  CommonOptions common;
  bool skip_bad_rows = false;
  std::string model, motions, config;
  std::optional<double> max_rms;     ///< [deg], of every joint that turns
  std::optional<double> max_rms_mm;  ///< of every joint that slides
};
ExitCode validateMotions(const MotionValidateOptions& options, const std::vector<std::string>& argv);

struct MotionDiagnoseOptions {
  CommonOptions common;
  bool skip_bad_rows = false;
  std::string model, motions, validation_motions, config;
  MotionDiagnosisOptions diagnose;
};
ExitCode diagnoseMotionSet(const MotionDiagnoseOptions& options, Session& session);

struct InterveneOptions;
/// What a diagnosis of motions left in its folder of candidates. \throws ConfigError, DataError: files that are none
MotionEvidence readMotionEvidence(const std::filesystem::path& run, Session& session);
ExitCode interveneOnMotions(const InterveneOptions& options, const std::vector<std::string>& argv);

/// Another set to judge by. \throws ConfigError: it is the first one
MotionSet readOtherMotions(Session& session, const std::string& file, const std::string& first, const ArmModel& model,
                           bool skip_bad_rows, double restart);

}  // namespace simgap
