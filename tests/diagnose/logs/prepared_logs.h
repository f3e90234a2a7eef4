/// \file
/// Small logs of simulated drives, ready for the pieces of a diagnosis.
#pragma once

#include "reality/drive_draws.h"
#include "simgap/measure/logs/prepared_log.h"

namespace simgap::test {

inline reality::DriveRig smallRig(std::size_t rows = 3000) {
  reality::DriveRig rig = reality::drawRig(3);
  rig.rows = rows;
  return rig;
}

inline PreparedLog preparedLog(const reality::DriveRig& rig, const reality::DriveSecret& secret = {}) {
  return prepareLog(CsvTable::parse(reality::recordDrive(rig, secret).csv(), "log.csv"), {}, ActuatorKind::kFriction);
}

}  // namespace simgap::test
