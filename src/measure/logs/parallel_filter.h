/// \file
/// What is measured beside a motion that was smoothed is smoothed alike: what a smoother takes from one side of an
/// equation it has to take from the other ("Dynamic identification of robots with power model", Gautier 1997).
#pragma once

#include <span>

#include "simgap/core/blocks.h"
#include "simgap/measure/logs/actuator_log.h"
#include "simgap/measure/logs/friction_rows.h"
#include "simgap/measure/logs/motion.h"

namespace simgap {

/// Smooths effort, and the load of a sensor, like the motion that was worked out, where they accelerate the drive
/// faster than that can follow; says so in `data`. Friction turns at once and stays so. Noise, ripple and jumps of a
/// load are left as they are: no motion goes with them. \param runs  as splitRuns. \param sign  of the motion.
void smoothLikeMotion(ActuatorLog& log, std::span<const Block> runs, const MotionSign& sign, FrictionData& data);

}  // namespace simgap
