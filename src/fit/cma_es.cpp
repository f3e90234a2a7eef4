#include "simgap/fit/cma_es.h"

#include <algorithm>
#include <cmath>
#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>

#include "simgap/core/random.h"

namespace simgap {
namespace {

constexpr std::uint32_t kPopulationPurpose = 4;
// pagmo wants bounds, and measures its step by their width. Nothing sensible is this many steps from the origin.
constexpr double kFar = 100.0;

struct Objective {
  const std::function<double(const std::vector<double>&)>* function = nullptr;
  std::size_t unknowns = 0;
  double far = 0.0;
  pagmo::vector_double fitness(const pagmo::vector_double& x) const { return {(*function)(x)}; }
  std::pair<pagmo::vector_double, pagmo::vector_double> get_bounds() const {
    return {pagmo::vector_double(unknowns, -far), pagmo::vector_double(unknowns, far)};
  }
};

}  // namespace

void minimiseByCmaEs(const std::function<double(const std::vector<double>&)>& objective, std::size_t unknowns,
                     const CmaEsOptions& options, const std::function<bool(const CmaEsGeneration&)>& after_generation) {
  // The first population is drawn about the origin as a CMA-ES would; pagmo itself would spread it over the bounds. Its
  // best becomes the first mean.
  const auto seed = static_cast<unsigned>(options.seed);
  pagmo::population population{pagmo::problem{Objective{&objective, unknowns, kFar * options.step}}, 0, seed};
  const CounterRandom random(options.seed);
  for (int k = 0; k < options.population; ++k) {
    std::vector<double> x(unknowns, 0.0);
    for (std::size_t i = 0; k > 0 && i < unknowns; ++i) {
      const RandomCounter counter{0, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(i), kPopulationPurpose};
      x[i] = options.step * random.normalPair(counter)[0];
    }
    population.push_back(x);
  }
  // One generation at a time with its memory kept, so that it can be watched and ended.
  pagmo::algorithm algorithm{pagmo::cmaes(1, -1, -1, -1, -1, 0.5 / kFar, 0.0, 0.0, true, true, seed)};
  for (int generation = 0; generation < options.generations; ++generation) {
    population = algorithm.evolve(population);
    CmaEsGeneration found{population.champion_x(), population.champion_f()[0], {}};
    for (const auto& fitness : population.get_f()) found.objectives.push_back(fitness[0]);
    if (after_generation(found)) return;
  }
}

}  // namespace simgap
