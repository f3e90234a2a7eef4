/// \file
/// The results of `calibrate-joints` and `targets check` as JSON, a table for the terminal and a page.
#pragma once

#include <string>

#include "simgap/measure/capture/joint_calibration.h"
#include "simgap/measure/capture/target_check.h"
#include "simgap/report/page.h"

namespace simgap {

Json toJson(const ArmJointCalibration& result);
std::string terminalTable(const ArmJointCalibration& result);
Page makePage(const ArmJointCalibration& result);

Json toJson(const TargetSetReport& report);
std::string terminalTable(const TargetSetReport& report);
Page makePage(const TargetSetReport& report);

}  // namespace simgap
