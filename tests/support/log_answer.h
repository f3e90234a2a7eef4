/// \file
/// `simgap diagnose` as the real program on logs with a secret: it sees files only, the test reads result.json.
#pragma once

#include <filesystem>
#include <optional>
#include <string>
#include <vector>

#include "reality/drive_draws.h"
#include "simgap/core/run_directory.h"

namespace simgap::test {

struct NamedCause {
  std::string effect;
  std::vector<std::string> ambiguous_with;
};

/// What the program said of one draw.
struct LogAnswer {
  reality::DriveDraw draw;
  Json result;
  double true_gain = 0.0;  ///< on unseen blocks, of the hidden effect alone on top of the model as it is

  std::string verdict() const { return result.at("verdict"); }
  std::vector<NamedCause> causes() const;
  bool silent() const { return verdict() == "nothing-found"; }
  bool namedAlone(const std::string& effect) const;
  bool namedInGroup(const std::string& effect) const;  ///< alone, or in a group of at most three
  bool names(const std::string& effect) const;         ///< among others
};

/// Runs `binary diagnose classic` on the draw in `folder`.
LogAnswer diagnoseDraw(const reality::DriveDraw& draw, const std::filesystem::path& folder, const std::string& binary);

/// The gain of the extended over the baseline model on a log of another motion with the same secret.
double gainOnFreshLog(const reality::DriveDraw& draw, const std::filesystem::path& folder, const std::string& binary);

}  // namespace simgap::test
