#include "simgap/optimize/cma_es.h"

#include "cma_es_module.h"
#include "simgap/core/module.h"
#include "simgap/core/random.h"

namespace simgap {
namespace {

constexpr std::uint32_t kPopulationPurpose = 4;

/// The first population, drawn about the origin as a CMA-ES would; pagmo itself would spread it over the bounds. Its
/// best becomes the first mean. \returns shape (population)(unknowns).
std::vector<std::vector<double>> firstPopulation(std::size_t unknowns, const CmaEsOptions& options) {
  const CounterRandom random(options.seed);
  std::vector<std::vector<double>> population;
  for (int k = 0; k < options.population; ++k) {
    std::vector<double>& x = population.emplace_back(unknowns, 0.0);
    for (std::size_t i = 0; k > 0 && i < unknowns; ++i) {
      const RandomCounter counter{0, static_cast<std::uint32_t>(k), static_cast<std::uint32_t>(i), kPopulationPurpose};
      x[i] = options.step * random.normalPair(counter)[0];
    }
  }
  return population;
}

}  // namespace

void minimiseByCmaEs(const std::function<double(const std::vector<double>&)>& objective, std::size_t unknowns,
                     const CmaEsOptions& options, const std::function<bool(const CmaEsGeneration&)>& after_generation) {
  using Module = CmaEsEntry (*)();
  static const CmaEsEntry evolve = reinterpret_cast<Module>(moduleEntry("cma_es", "simgapCmaEsModule"))();
  evolve(objective, firstPopulation(unknowns, options), options, after_generation);
}

}  // namespace simgap
