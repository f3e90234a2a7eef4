/// \file
/// What is wrong with a channel before physics: constant, clipped, stuck, or in the wrong unit.
#pragma once

#include <span>
#include <string>
#include <vector>

namespace simgap {

struct ChannelCheck {
  std::string name;  ///< "motor_current_A"
  std::span<const double> values;
  double plausible;  ///< largest size a sane unit gives
};

/// Sentences about the channels that look wrong but can still be used.
/// \throws DataError: a value beyond the plausible size; the sentence names the row's value and the likely cause.
std::vector<std::string> checkChannels(const std::string& file, std::span<const ChannelCheck> channels);

bool isConstant(std::span<const double> values);

/// A log of rests says nothing.
/// \param name  "deflection_m"  \param driven  what should follow the values; both of shape (rows)
/// \throws DataError: the values are constant, or never leave their own noise while what they drive does not follow
void requireMotion(const std::string& file, const std::string& name, std::span<const double> values,
                   std::span<const double> driven);

}  // namespace simgap
