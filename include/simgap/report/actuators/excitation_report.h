/// \file
/// The result of `design --excite` as JSON, tables and trajectory files (docs/formats.md).
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/fit/dynamics/excitation.h"
#include "simgap/report/table.h"

namespace simgap {

struct ExcitationReport {
  ArmModel robot;
  std::string law;
  ExcitationLimits limits;
  Excitation found;
};

Json toJson(const ExcitationReport& report);
/// time_s; of each joint J its J_rad, J_velocity_rad_s, J_acceleration_rad_s2 ([m] of slides).
std::string trajectoryCsv(const ExcitationReport& report);
/// trajectory_msgs/JointTrajectory of ROS 2, as JSON.
Json rosTrajectory(const ExcitationReport& report);
std::string excitationAnswer(const Json& result);
std::vector<Table> excitationTables(const Json& result);
std::string excitationText(const Json& result);

}  // namespace simgap
