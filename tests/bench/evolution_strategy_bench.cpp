/// \file
/// What the strategy itself costs per generation at the size of the whole arm (99 parameters, 36 offspring); an
/// evaluation of the arm takes seconds.
#include <benchmark/benchmark.h>

#include <limits>
#include <vector>

#include "simgap/optimize/evolution_strategy.h"

namespace {

using namespace simgap;

void askAndTell(benchmark::State& state) {
  EvolutionStrategyOptions options;
  options.generations = std::numeric_limits<int>::max();
  const auto parameters = static_cast<std::size_t>(state.range(0));
  EvolutionStrategy strategy(std::vector<ObjectParameter>(parameters, {0.0, 1.0, -1.0, 1.0}), options);
  const CounterRandom random(1);
  std::vector<double> fitness;
  for (std::uint32_t k = 0; k < 36; ++k) fitness.push_back(random.uniform({0, k, 0, 0}));
  for (auto _ : state) {
    benchmark::DoNotOptimize(strategy.ask().data());
    strategy.tell(fitness);
  }
  state.counters["per_parameter"] =
      benchmark::Counter(static_cast<double>(36 * parameters * static_cast<std::size_t>(state.iterations())),
                         benchmark::Counter::kIsRate | benchmark::Counter::kInvert);
}
BENCHMARK(askAndTell)->Arg(1)->Arg(10)->Arg(99)->Unit(benchmark::kMicrosecond);

}  // namespace
