/// \file
/// What fit-motor and fit-gearbox share.
#pragma once

#include "fit_options.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/drive_fit.h"

namespace simgap {

struct DriveCommandOptions {
  CommonOptions common;
  TableOptions table;
  FitOptions fit;
  std::string log, into, muscle;
  const CLI::App* app = nullptr;
  void add(CLI::App& command);
};

/// Reads, fits, reports. \param kind  "motor" or "gearbox".
ExitCode runDriveFit(const std::string& kind, const DriveCommandOptions& options, Session& session,
                     DriveFitOptions drive);

}  // namespace simgap
