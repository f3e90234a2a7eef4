/// \file
/// How finely a channel was measured: the steps of its converter and the noise upon them.
#pragma once

#include <span>

namespace simgap {

/// The smallest step between two rows: one count of a coarse channel, next to nothing of a fine one. 0 when constant.
double quantumOf(std::span<const double> values);

/// Standard deviation of a channel's white noise, from the median size of its second differences; at least a quarter
/// of the smallest step of a quantised channel. 0 for fewer than 3 rows.
double noiseLevel(std::span<const double> values);

}  // namespace simgap
