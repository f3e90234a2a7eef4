/// \file
/// Noise of a measured load. A least-squares fit of the effort takes such noise for load that moves nothing: k_a comes
/// out too large by the noise's share of the load's variance (errors in variables), and whatever is a quieter copy of
/// the load, as the weight over the angle, passes for a cause.
#pragma once

#include <span>

#include "simgap/core/blocks.h"
#include "simgap/measure/logs/actuator_log.h"
#include "simgap/measure/logs/friction_rows.h"

namespace simgap {

/// Smooths the load to the bandwidth at which it is nearest to the truth, where its noise would bend a fit and the
/// effort does not answer to it, which `data` says. \param runs  as splitRuns
void smoothNoisyLoad(ActuatorLog& log, std::span<const Block> runs, FrictionData& data);

}  // namespace simgap
