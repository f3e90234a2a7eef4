/// \file
/// Simulated friction logs as the fits take them.
#pragma once

#include "reality/friction_log.h"
#include "simgap/measure/logs/friction_rows.h"

namespace simgap::test {

inline FrictionData frictionData(const reality::FrictionLog& log, const FrictionDataOptions& options = {}) {
  return prepareFrictionData(readActuatorLog(CsvTable::parse(log.csv(), "log.csv"), {}), {}, options);
}

}  // namespace simgap::test
