/// \file
/// The size of 003's measurement (4958 s at 50 Hz): reading the log, and the global fit of each law.
#include <benchmark/benchmark.h>

#include "reality/friction_log.h"
#include "simgap/fit/actuators/friction_fit.h"

namespace {

using namespace simgap;

const std::string& logText() {
  static const std::string text = [] {
    reality::FrictionTruth truth;
    truth.sliding_offset = 1.2;
    truth.noise = 0.87;
    return reality::simulateFrictionLog(truth, {.rows = 247900, .sessions = 20}).csv();
  }();
  return text;
}

void readCsv(benchmark::State& state) {
  for (auto _ : state) benchmark::DoNotOptimize(CsvTable::parse(logText(), "log.csv").rows());
  state.SetBytesProcessed(static_cast<std::int64_t>(state.iterations()) * static_cast<std::int64_t>(logText().size()));
}
BENCHMARK(readCsv)->Unit(benchmark::kMillisecond)->UseRealTime();

FrictionData prepared() {
  return prepareFrictionData(readActuatorLog(CsvTable::parse(logText(), "log.csv"), {}), {}, {});
}

void prepare(benchmark::State& state) {
  const CsvTable table = CsvTable::parse(logText(), "log.csv");
  for (auto _ : state) benchmark::DoNotOptimize(prepareFrictionData(readActuatorLog(table, {}), {}, {}).rows());
}
BENCHMARK(prepare)->Unit(benchmark::kMillisecond)->UseRealTime();

void fitGlobally(benchmark::State& state, const char* law) {
  const FrictionData data = prepared();
  for (auto _ : state) benchmark::DoNotOptimize(fitFriction(friction::find(law), data, {}).mse);
}
BENCHMARK_CAPTURE(fitGlobally, classic, "classic")->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(fitGlobally, variant_a, "variant-a")->Unit(benchmark::kMillisecond)->UseRealTime();
BENCHMARK_CAPTURE(fitGlobally, variant_b, "variant-b")->Unit(benchmark::kMillisecond)->UseRealTime();

}  // namespace
