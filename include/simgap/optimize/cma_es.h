/// \file
/// Covariance matrix adaptation (Hansen 2006) by pagmo, as a peer of the paper's evolution strategy.
#pragma once

#include <cstdint>
#include <functional>
#include <vector>

namespace simgap {

struct CmaEsOptions {
  int population = 36;
  int generations = 250;
  double step = 1.0;  ///< initial standard deviation of every unknown
  std::uint64_t seed = 1;
};

/// One generation of it.
struct CmaEsGeneration {
  std::vector<double> best;        ///< of its population
  double best_objective;           ///< of `best`
  std::vector<double> objectives;  ///< shape (population)
};

/// Minimises `objective`, which must be finite everywhere, from the origin.
/// \param after_generation  true ends the search
void minimiseByCmaEs(const std::function<double(const std::vector<double>&)>& objective, std::size_t unknowns,
                     const CmaEsOptions& options, const std::function<bool(const CmaEsGeneration&)>& after_generation);

}  // namespace simgap
