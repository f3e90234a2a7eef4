/// \file
/// The result of `design`: which poses to record next, and what they are worth.
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/fit/poses/pose_design.h"

namespace simgap {

Json toJson(const DesignResult& result);
/// The commands, ready for the rig: pose, shaft_<muscle>_rad, and where the model expects the joints.
std::string nextPosesCsv(const DesignResult& result);
std::string terminalTable(const DesignResult& result);
/// model.yaml, next_poses.csv, and the arm in these poses for the page.
void writeDesignReport(const DesignResult& result, const RunDirectory& directory);

}  // namespace simgap
