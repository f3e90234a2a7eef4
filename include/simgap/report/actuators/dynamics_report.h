/// \file
/// What `fit-dynamics` shows and writes: errors per joint before and after, base parameters, the robot that was found.
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/fit/dynamics/robot_fit.h"
#include "simgap/measure/logs/robot_log.h"

namespace simgap {

struct DynamicsReport {
  ArmModel file;  ///< the robot as its file has it
  RobotLog log;
  RobotFit found;
};

Json toJson(const DynamicsReport& report);
std::string terminalTable(const DynamicsReport& report);
/// model.yaml, arm.yaml, base_parameters.csv, parameters.csv, predictions.csv.
void writeDynamicsReport(const DynamicsReport& report, const RunDirectory& directory);

}  // namespace simgap
