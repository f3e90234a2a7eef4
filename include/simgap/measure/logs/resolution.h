/// \file
/// How finely a channel was measured: the steps of its converter and the noise upon them.
#pragma once

#include <cstddef>
#include <span>
#include <vector>

#include "simgap/core/blocks.h"

namespace simgap {

/// The smallest step between two rows: one count of a coarse channel, next to nothing of a fine one. 0 when constant.
double quantumOf(std::span<const double> values);

/// Standard deviation of a channel's white noise, from the median size of its second differences; at least a quarter
/// of the smallest step of a quantised channel. 0 for fewer than 3 rows.
double noiseLevel(std::span<const double> values);

/// Rows in a row that stand exactly on `value`.
std::vector<Block> runsAt(std::span<const double> values, double value);

/// Whether a channel comes to one of its ends by single counts, in most of the runs of at least `least` rows there: a
/// level that it settles at, as a motor at its top speed on the grid of an encoder. What runs into a limit is cut off
/// on its way, many counts (or its noise) before it. \param end  the channel's largest or smallest value
bool comesByCounts(std::span<const double> values, double end, std::size_t least);

}  // namespace simgap
