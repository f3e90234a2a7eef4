/// \file
/// What `simulate` shows and writes of a drive with a cable that follows a path (003 fig. 6).
#pragma once

#include <string>

#include "simgap/report/table.h"
#include "simgap/simulate/cable_drive_study.h"

namespace simgap {

Json toJson(const CableDrive& drive, const CableDriveCommands& commands, const CableDriveStudy& study);
/// The answer in sentences, from the result's JSON.
std::string cableDriveAnswer(const Json& result);
/// A row per compensation, from the result's JSON: how well it follows, and what it draws.
Table driveTrackingTable(const Json& result);
/// The same of a path's error: what motor and cable have in it, and what set-points and trapezoids cost before it.
Table driveErrorTable(const Json& result);
std::string cableDriveText(const Json& result);

/// tracking.csv: all runs.
void writeCableDrive(const CableDriveStudy& study, bool torque, const RunDirectory& directory);

}  // namespace simgap
