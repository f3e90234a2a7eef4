/// \file
/// Velocity and acceleration of logs that do not hold them.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "simgap/core/blocks.h"
#include "simgap/measure/logs/actuator_log.h"
#include "simgap/measure/logs/friction_rows.h"

namespace simgap {

/// What a slope takes, two gaps in a log may leave less of.
inline constexpr std::size_t kFewestInARow = 4;
bool isTooShort(const Block& run);

/// Velocity and acceleration of a channel that is smoothed to `bandwidth` [Hz], shape (rows); 0 in runs that are too
/// short. \param measured  a position, or with `of_velocity` a velocity
struct SmoothMotion {
  std::vector<double> velocity, acceleration;
};
SmoothMotion smoothMotion(std::span<const double> time, std::span<const double> measured, bool of_velocity,
                          std::span<const Block> runs, double bandwidth);

/// Fills velocity from position, and acceleration if that is wanted from a measured velocity, else from position; says
/// in `data` what was derived and with which bandwidth. \param runs  as splitRuns. \param bandwidth  [Hz] of the
/// smoothing; none: as suits the channel. In runs that are too short both stay 0.
/// \throws DataError: no time, or no run that is long enough.
void completeMotion(ActuatorLog& log, std::span<const Block> runs, std::optional<double> bandwidth, bool acceleration,
                    FrictionData& data);

/// Half width of the dead band of a velocity that was worked out from positions. \param widths  in noise levels.
double derivedDeadBand(const ActuatorLog& log, std::span<const Block> runs, double bandwidth, double widths);

}  // namespace simgap
