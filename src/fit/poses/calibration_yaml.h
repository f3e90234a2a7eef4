/// \file
/// The parts of `simgap/calibration/1` that configurations for poses and for motions share.
#pragma once

#include <string>

#include "simgap/core/yaml.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/optimize/evolution_strategy.h"

namespace simgap {

EvolutionStrategyOptions readStrategy(const YamlNode& node);
std::string strategyYaml(const EvolutionStrategyOptions& options);  ///< the block, with its key
std::string choiceYaml(const ParameterSpace::Choice& choice);       ///< an item of `parameters:`

}  // namespace simgap
