/// \file
/// What a user says about single parameters of a fit: known values and bounds.
#pragma once

#include <map>
#include <span>
#include <string>
#include <vector>

#include "simgap/fit/actuators/friction_fit.h"

namespace simgap {

struct ParameterChoices {
  std::map<std::string, double> fixed;   ///< parameter -> value, SI
  std::map<std::string, Bounds> bounds;  ///< instead of the model's own, SI
};

/// \param fix  "k_a=1.3" each. \param bounds  "k_v=0:5" each.
/// \throws ConfigError: a text that is no such entry, a lower bound that is not below the upper one.
ParameterChoices readParameterChoices(std::span<const std::string> fix, std::span<const std::string> bounds);

/// \param known  names of the models' parameters; a name may stand there several times.
/// \throws ConfigError when `choices` names a parameter that none of the models has.
void requireKnown(const ParameterChoices& choices, std::span<const std::string> known);

/// Puts the chosen bounds into `parameters`, and marks the known ones as fixed.
void constrain(const ParameterChoices& choices, std::span<ParameterSpec> parameters);
/// Puts the known values into theta, shape (P) like `parameters`.
void fixValues(std::span<const ParameterSpec> parameters, const std::map<std::string, double>& fixed,
               std::span<double> theta);

}  // namespace simgap
