/// \file
/// What follows from the causes that a search has accepted, whatever the data were: the same rules for logs and poses.
#pragma once

#include <string>
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

/// Nothing is fitted to data with such a fault.
void endWith(const DataFault& fault, Diagnosis& diagnosis);

/// "joint-spring of j2".
std::string nameOf(const Cause& cause);
/// "bend-friction, joint-spring of j2 or joint-gravity".
std::string namesOf(const std::vector<Cause>& causes);

/// How many standard deviations an effect has to be large to be found: a z of 3 for the number of hypotheses, 1.6 for
/// 95 % power, and the least gain.
double detectionFactor(double least_gain, double effective_samples);

/// Of all shifts of ordinary parameters those of two standard deviations and more, the largest first, at most five.
std::vector<Absorption> absorbed(std::vector<Absorption> shifts);

}  // namespace simgap
