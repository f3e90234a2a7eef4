/// \file
/// What a diagnosis of a robot says of each joint.
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/diagnose/robots/robot_diagnosis.h"
#include "simgap/report/table.h"

namespace simgap {

/// \param result  result.json of a diagnosis of a robot
Table robotSays(const Json& result);

/// Time, and of every joint its measured effort and what was predicted without and with the causes.
std::string robotPredictionsCsv(const RobotDiagnosis& result, const RobotLog& log);

}  // namespace simgap
