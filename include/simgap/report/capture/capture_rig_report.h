/// \file
/// The results of `calibrate-joints` and `targets check` as JSON and a table for the terminal.
#pragma once

#include <string>

#include "simgap/capture/rig_calibration.h"
#include "simgap/capture/target_check.h"
#include "simgap/core/run_directory.h"

namespace simgap {

Json toJson(const RigCalibration& result);
std::string terminalTable(const RigCalibration& result);

Json toJson(const TargetSetReport& report);
std::string terminalTable(const TargetSetReport& report);

}  // namespace simgap
