/// \file
/// What `calibrate` copies into its result directory, so that --resume needs nothing else; and how what a run has kept
/// is read again.
#pragma once

#include <filesystem>
#include <functional>
#include <string>
#include <vector>

#include "simgap/cli/session.h"
#include "simgap/fit/poses/calibration.h"

namespace simgap {

inline constexpr const char* kKeptConfig = "config.resolved.yaml";

/// Paths of the copies, and how tables among them are read.
struct KeptInputs {
  std::vector<std::string> map;
  bool skip_bad_rows = false;
  std::string model, poses;
  std::string validation;  ///< empty: none
};

/// Copies the inputs of a session that has begun. On the first rank alone.
void keepInputs(const Session& session, const TableOptions& table, const CalibrationConfig& config);

/// Gives `take` what the first rank has read, for all ranks. \param file  of the run that is resumed, for messages
/// \throws ConfigError: `read` or `take` found no calibration that can be resumed
void takeKept(const std::filesystem::path& file, const std::function<Json()>& read,
              const std::function<void(const Json& kept)>& take);

/// \throws ConfigError: no directory of a calibration, or one whose copies lie elsewhere
KeptInputs readKeptInputs(const std::filesystem::path& resumed);

}  // namespace simgap
