/// \file
/// `calibrate` and `validate` with --motions.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "simgap/cli/session.h"
#include "simgap/core/error.h"

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

}  // namespace simgap
