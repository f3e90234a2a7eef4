/// \file
/// What a log cannot tell a friction law, in sentences.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "friction_model.h"

namespace simgap {

/// What the log lacks for this law, as one sentence; empty when nothing.
std::string missingForLaw(const FrictionModel& model, const FrictionData& data, bool predict_load);

/// Why this result is none: a channel with the wrong sign, a gain or a friction that is unbounded; empty when it is
/// one.
std::string degenerateFit(const FrictionModel& model, const FrictionData& data, std::span<const double> theta,
                          bool predict_load);

/// Warnings about what the motion cannot show.
std::vector<std::string> motionGaps(const FrictionModel& model, const FrictionData& data,
                                    std::span<const double> theta);

}  // namespace simgap
