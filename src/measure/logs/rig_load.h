/// \file
/// The load of a rig on the drive that moves it.
#pragma once

#include "simgap/measure/logs/actuator_log.h"
#include "simgap/measure/logs/bench.h"
#include "simgap/measure/logs/friction_rows.h"

namespace simgap {

/// Fills `load`, `load_per` and the rig's constants, in the signs of 003 eq. 3: what the motor must overcome in the
/// positive direction. \param log  with the acceleration that the rig needs.
/// \throws DataError: a channel is missing; ConfigError: a session of the log that the bench does not have.
void workOutLoad(const ActuatorLog& log, const Bench& bench, FrictionData& data);

}  // namespace simgap
