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

namespace simgap {

struct MotionCalibrateOptions {
  CommonOptions common;
  bool skip_bad_rows = false;
  std::string model, motions, validation_motions, poses, config;
  std::filesystem::path resume;  ///< empty: a new run
  std::optional<std::string> optimizer;
  std::optional<int> generations, mu, lambda;
  std::optional<double> target_fitness;
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
/// Whether a diagnosis was of motions.
bool holdsMotionCandidates(const std::filesystem::path& run);
ExitCode interveneOnMotions(const InterveneOptions& options, const std::vector<std::string>& argv);

/// Calibration settings for motions: those the user named, or the built-in ones. \throws ConfigError: also for
/// parameters that `model` does not have
MotionCalibrationConfig readMotionConfig(Session& session, const std::string& file, const ArmModel& model);
/// Another set to judge by. \throws ConfigError: it is the first one
MotionSet readOtherMotions(Session& session, const std::string& file, const std::string& first, const ArmModel& model,
                           bool skip_bad_rows, double restart);

}  // namespace simgap
