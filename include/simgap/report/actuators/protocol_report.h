/// \file
/// The result of `design --drive` as JSON, tables and the log to record (docs/formats.md).
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/fit/actuators/bench_protocol.h"
#include "simgap/report/table.h"

namespace simgap {

struct ProtocolReport {
  DriveLimits limits;
  BenchProtocol found;
};

Json toJson(const ProtocolReport& report);
/// The log as it is expected to come out: time_s, session, joint_position_rad, joint_velocity_rad_s,
/// joint_acceleration_rad_s2, external_torque_Nm, motor_current_A.
std::string protocolCsv(const ProtocolReport& report);
std::string protocolAnswer(const Json& result);
/// Sessions in their order, and what every parameter is expected to be known to.
std::vector<Table> protocolTables(const Json& result);
std::string protocolText(const Json& result);

}  // namespace simgap
