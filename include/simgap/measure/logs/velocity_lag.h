/// \file
/// A velocity that is logged beside a position is often an estimate that is late: a drive filters it, a tachometer's
/// amplifier does. By kinematics it is the position's slope, so that the two tell the lag; left where it is, every
/// other channel looks late or early against it, and an inertia takes up what is left.
#pragma once

#include <optional>
#include <span>
#include <vector>

#include "simgap/core/blocks.h"

namespace simgap {

/// By how much the velocity follows the slope of the position later (negative: earlier) [s], where the two, smoothed
/// alike, differ least. None where it is less than half a row, where the two do not follow each other anyway, and
/// where moving one of them does not halve the variance that they do not share.
/// \param time  [s], \param position, velocity  shape (n). \param runs  that may be smoothed (splitRuns).
std::optional<double> velocityLag(std::span<const double> time, std::span<const double> position,
                                  std::span<const double> velocity, std::span<const Block> runs);

/// The values as they are `lag` [s] later, between the rows that are nearest; at the ends of a run the last of it.
std::vector<double> moved(std::span<const double> time, std::span<const double> values, std::span<const Block> runs,
                          double lag);

}  // namespace simgap
