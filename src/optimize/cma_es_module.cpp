#include "cma_es_module.h"

#include <pagmo/algorithm.hpp>
#include <pagmo/algorithms/cmaes.hpp>
#include <pagmo/population.hpp>
#include <pagmo/problem.hpp>
#include <utility>

namespace simgap {
namespace {

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

void evolve(const CmaEsObjective& objective, const std::vector<std::vector<double>>& start, const CmaEsOptions& options,
            const CmaEsObserver& after_generation) {
  const auto seed = static_cast<unsigned>(options.seed);
  const std::size_t unknowns = start.front().size();
  pagmo::population population{pagmo::problem{Objective{&objective, unknowns, kFar * options.step}}, 0, seed};
  for (const std::vector<double>& x : start) population.push_back(x);
  // One generation at a time with its memory kept, so that it can be watched and ended.
  pagmo::algorithm algorithm{pagmo::cmaes(1, -1, -1, -1, -1, 0.5 / kFar, 0.0, 0.0, true, true, seed)};
  for (int generation = 0; generation < options.generations; ++generation) {
    population = algorithm.evolve(population);
    CmaEsGeneration found{population.champion_x(), population.champion_f()[0], {}};
    for (const auto& fitness : population.get_f()) found.objectives.push_back(fitness[0]);
    if (after_generation(found)) return;
  }
}

}  // namespace
}  // namespace simgap

simgap::CmaEsEntry simgapCmaEsModule() { return simgap::evolve; }
