/// \file
/// What a model contains beyond its own equations: one entry of `extensions:` per physical cause (docs/formats.md).
///
///     extensions:
///       - {effect: muscle-wrap, target: biceps, parameters: {radius: {value: 0.02, unit: "m", sd: 0.001}}}
#pragma once

#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/optimize/parameter.h"

namespace simgap {

struct Extension {
  std::string effect;  ///< a name of the catalogue
  std::string target;  ///< which muscle, body or joint; empty for an effect of the whole
  std::vector<Estimate> parameters;
  std::string form = {};  ///< of an effect that has several; empty: its usual one

  /// \throws ConfigError when there is no such parameter.
  double value(std::string_view name) const;
};

/// "payload:forearm"; without a target "gravity-tilt".
std::string effectLabel(std::string_view effect, std::string_view target);

/// Reads the list under `extensions:`. Which effects and parameters exist is the caller's to check.
std::vector<Extension> readExtensions(const YamlNode& list);

/// The whole `extensions:` key as block YAML, "extensions: []\n" when there are none.
std::string writeExtensions(const std::vector<Extension>& extensions);

}  // namespace simgap
