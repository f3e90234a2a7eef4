/// \file
/// The results of `calibrate-joints` and `targets check` as JSON and a table for the terminal.
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/measure/capture/joint_calibration.h"
#include "simgap/measure/capture/target_check.h"

namespace simgap {

Json toJson(const ArmJointCalibration& result);
std::string terminalTable(const ArmJointCalibration& result);

Json toJson(const TargetSetReport& report);
std::string terminalTable(const TargetSetReport& report);

}  // namespace simgap
