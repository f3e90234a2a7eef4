/// \file
/// `diagnose` with a robot and the log of all its joints.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "cli/fit_options.h"
#include "simgap/diagnose/robots/robot_diagnosis.h"

namespace simgap {

struct RobotDiagnoseOptions {
  CommonOptions common;
  LogFileOptions table;
  std::string robot;
  std::vector<std::string> logs;
  std::vector<double> torque_constants;  ///< empty: those of the robot's file
  RobotDiagnosisOptions diagnose;
};

/// Whether MODEL names a robot's file and not the model, or the law, of a single actuator.
bool namesRobot(Session& session, const std::string& model);
ExitCode diagnoseRobotLog(const RobotDiagnoseOptions& options, Session& session, const CLI::App& app);

}  // namespace simgap
