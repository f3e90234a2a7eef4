/// \file
/// What fit-motor and fit-gearbox share, and what all fits share that write into an arm.
#pragma once

#include "fit_options.h"
#include "simgap/core/error.h"
#include "simgap/fit/actuators/drive_fit.h"
#include "simgap/report/actuators/drive_report.h"

namespace simgap {

struct DriveCommandOptions {
  CommonOptions common;
  LogFileOptions table;
  FitOptions fit;
  std::string log, into, muscle;
  const CLI::App* app = nullptr;
  void add(CLI::App& command);
};

/// The arm of --into, with the muscle of --muscle whose part is fitted; none without both.
/// \throws ConfigError: one without the other, a muscle that the arm does not have.
std::optional<ArmWithDrive> readTarget(const std::string& into, const std::string& muscle, Session& session);

/// Reads, fits, reports. \param kind  "motor" or "gearbox".
ExitCode runDriveFit(const std::string& kind, const DriveCommandOptions& options, Session& session,
                     DriveFitOptions drive);

}  // namespace simgap
