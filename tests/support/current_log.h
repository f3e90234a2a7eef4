/// \file
/// Logs that a test fills by itself.
#pragma once

#include "simgap/measure/logs/actuator_log.h"

namespace simgap::test {

/// A log of a motor's current over time, without rows and sessions.
inline ActuatorLog currentLog(const char* file) {
  ActuatorLog log;
  log.file = file;
  log.effort_name = "motor_current";
  log.effort_unit = "A";
  log.has_time = true;
  return log;
}

}  // namespace simgap::test
