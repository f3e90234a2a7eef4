/// \file
/// Steps of an integration within a controller's tick.
#pragma once

#include <cmath>

namespace simgap {

/// How many equal steps of at most `step` a tick takes. \param tick, step [s]
inline int stepsPerTick(double tick, double step) { return static_cast<int>(std::ceil(tick / step - 1e-9)); }

/// The step that is then taken: where a tick is no multiple of `step`, or shorter, it is less. [s]
inline double stepWithinTick(double tick, double step) { return tick / stepsPerTick(tick, step); }

}  // namespace simgap
