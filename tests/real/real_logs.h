/// \file
/// Public measured logs (docs/studies/real-logs.md) with what is known of their rigs. None of them is part of this
/// repository: they lie in the folder that SIMGAP_REAL_DATA names, or in ../shared/data/real beside the source tree.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"

namespace simgap::test {

struct RealLog {
  std::string name, law, file;  ///< file: in the folder
  std::string bench;            ///< YAML without its format line; empty: none is needed
  std::vector<std::string> options;
  std::vector<std::string> truth;    ///< causes that are known to be there and large
  std::vector<std::string> allowed;  ///< causes that may be: known of the rig, but not how large
  std::string reason;                ///< how that is known
};

/// The folder of the logs; none where there is no such folder.
std::optional<std::filesystem::path> realFolder();
/// Another folder beside it; none where it is missing.
std::optional<std::filesystem::path> standstillFolder();

const std::vector<RealLog>& realLogs();
const RealLog& realLog(const std::string& name);

/// What the program says of a log.
struct RealAnswer {
  Json result;
  std::vector<std::vector<std::string>> named;  ///< a cause, with those it cannot be told from
  std::string error;                            ///< its sentence, where it did not end well

  std::string verdict() const;
  bool names(const std::string& effect) const;
  /// \returns nullptr where the first cause of that name is missing.
  const Json* cause(const std::string& effect) const;
  std::string text() const;
};

/// Runs `simgap diagnose` in `folder` (result in folder/d). \param log  the CSV file.
RealAnswer diagnoseReal(const RealLog& real, const std::filesystem::path& log, const std::filesystem::path& folder,
                        const std::string& binary);

}  // namespace simgap::test
