/// \file
/// What follows from the causes that a search has accepted, whatever the data were: the same rules for logs and poses.
#pragma once

#include <vector>

#include "simgap/diagnose/diagnosis.h"

namespace simgap {

/// Causes that cannot be told apart make an answer up to this many; more are none.
inline constexpr std::size_t kLargestGroup = 3;

/// A size is no measurement where half of its 95 % interval is that many times as large.
inline constexpr double kMeaningless = 3.0;

/// Whether a cause is one of so many look-alikes that naming it would be no answer.
bool isLost(const std::vector<std::string>& ambiguous_with);

/// \param structure  is left beside the causes: a verdict of its own only where nothing was found
DiagnosisVerdict verdictOf(const std::vector<Cause>& causes, bool structure);

/// The first fault that was not put right; null when there is none.
const DataFault* openFault(const std::vector<DataFault>& faults);

/// Of all shifts of ordinary parameters those of two standard deviations and more, the largest first, at most five.
std::vector<Absorption> absorbed(std::vector<Absorption> shifts);

}  // namespace simgap
