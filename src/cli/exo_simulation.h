/// \file
/// `simulate` of what is no arm: a joint of two pneumatic muscles and a motor (`simgap/exo-joint/1`), a leg in an
/// exoskeleton (`simgap/exo-leg/1`), a drive with a cable (`simgap/cable-drive/1`).
#pragma once

#include <optional>
#include <string>

#include "simgap/cli/session.h"
#include "simgap/core/error.h"
#include "simgap/core/yaml.h"

namespace simgap {

struct ExoSimulateOptions {
  CommonOptions common;
  TableOptions table;
  std::string file, commands;
  bool linear = false;
  double rate = 100.0;  ///< of the rows that are written [Hz]
  double step = 1e-4;   ///< [s]
  std::optional<double> duration;
};

/// Whether a file is one of them.
bool holdsExo(const YamlNode& root);
/// \param root  of the file
ExitCode simulateExo(const ExoSimulateOptions& options, const YamlNode& root, Session& session);

}  // namespace simgap
