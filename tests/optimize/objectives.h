/// \file
/// Objectives and helpers of the tests of the evolution strategy.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include "simgap/optimize/evolution_strategy.h"

namespace simgap {

using Objective = std::function<double(const std::vector<double>&)>;

inline double sphere(const std::vector<double>& y) {
  double sum = 0.0;
  for (const double value : y) sum += value * value;
  return sum;
}

/// Sum of (w_j y_j)^2, w from 1 to 1000: its level sets have an axis ratio of 1000.
inline double ellipsoid(const std::vector<double>& y) {
  double sum = 0.0;
  for (std::size_t j = 0; j < y.size(); ++j) {
    const double w = std::pow(1e3, static_cast<double>(j) / static_cast<double>(y.size() - 1));
    sum += w * w * y[j] * y[j];
  }
  return sum;
}

inline std::vector<ObjectParameter> box(int n, double initial, double step) {
  return std::vector<ObjectParameter>(static_cast<std::size_t>(n), {initial, step, -100.0, 100.0});
}

inline EvolutionStrategyOptions optionsOf(int generations, std::uint64_t seed = 1) {
  EvolutionStrategyOptions options;
  options.generations = generations;
  options.seed = seed;
  return options;
}

inline void step(EvolutionStrategy& strategy, const Objective& objective) {
  std::vector<double> fitness;
  for (const Individual& child : strategy.ask()) fitness.push_back(objective(child.y));
  strategy.tell(fitness);
}

}  // namespace simgap
