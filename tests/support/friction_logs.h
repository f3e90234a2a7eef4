/// \file
/// Simulated friction logs as the fits take them.
#pragma once

#include "reality/friction_log.h"
#include "simgap/fit/friction_data.h"

namespace simgap::test {

inline FrictionData frictionData(const reality::FrictionLog& log, const FrictionDataOptions& options = {}) {
  return prepareFrictionData(readDriveLog(CsvTable::parse(log.csv(), "log.csv"), {}), {}, options);
}

}  // namespace simgap::test
