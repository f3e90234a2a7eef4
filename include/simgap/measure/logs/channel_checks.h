/// \file
/// What is wrong with a channel before physics: constant, clipped, stuck, or in the wrong unit.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "simgap/core/blocks.h"

namespace simgap {

struct ChannelCheck {
  std::string name;  ///< "motor_current_A"
  std::span<const double> values;
  double plausible;  ///< largest size a sane unit gives
};

/// Sentences about the channels that look wrong but can still be used.
/// \throws DataError: a value beyond the plausible size; the sentence names the row's value and the likely cause.
std::vector<std::string> checkChannels(const std::string& file, std::span<const ChannelCheck> channels);

/// Of a command of steps, at most so many: its limits are no clipping, and a law of as many numbers meets it exactly.
inline constexpr std::size_t kMostSteps = 6;

/// How many different values there are, or one more than `most`.
std::size_t differentValues(std::span<const double> values, std::size_t most);

/// \throws DataError: an effort that takes no more values than a command of steps does
void requireMoreThanSteps(const std::string& file, const std::string& name, std::span<const double> values);

/// Runs of rows, 0.2 s and longer, in which a voltage is exactly 0 while the drive moves faster than `slow` at some
/// time: the motor is switched off. All of shape (rows).
std::vector<Block> switchedOff(std::span<const double> time, std::span<const int> session,
                               std::span<const double> voltage, std::span<const double> velocity, double slow);

bool isConstant(std::span<const double> values);

/// A log of rests says nothing.
/// \param name  "deflection_m"  \param driven  what should follow the values; both of shape (rows)
/// \throws DataError: the values are constant, or never leave their own noise while what they drive does not follow
void requireMotion(const std::string& file, const std::string& name, std::span<const double> values,
                   std::span<const double> driven);

}  // namespace simgap
