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
/// \throws ConfigError: a text that is no such entry, a lower bound that is not below the upper one, a name that stands
///         there twice.
ParameterChoices readParameterChoices(std::span<const std::string> fix, std::span<const std::string> bounds);

/// \param known  names of the models' parameters; a name may stand there several times.
/// \throws ConfigError when `choices` names a parameter that none of the models has.
void requireKnown(const ParameterChoices& choices, std::span<const std::string> known);

/// Puts the chosen bounds into `parameters`, and marks the known ones as fixed. The bounds that stand there say what a
/// parameter can be: not below 0 where they are not, not 0 where they begin above it, and no share (a number up to 1)
/// above 1.
/// \throws ConfigError: a value or a bound that the parameter cannot have.
void constrain(const ParameterChoices& choices, std::span<ParameterSpec> parameters);
/// Puts the known values into theta, shape (P) like `parameters`.
void fixValues(std::span<const ParameterSpec> parameters, const std::map<std::string, double>& fixed,
               std::span<double> theta);

}  // namespace simgap
