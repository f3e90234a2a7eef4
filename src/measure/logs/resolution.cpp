#include "simgap/measure/logs/resolution.h"

#include <algorithm>
#include <cmath>
#include <vector>

#include "simgap/core/statistics.h"

namespace simgap {

double quantumOf(std::span<const double> values) {
  double quantum = 0.0;
  for (std::size_t i = 1; i < values.size(); ++i) {
    const double step = std::abs(values[i] - values[i - 1]);
    if (step > 0.0 && (quantum == 0.0 || step < quantum)) quantum = step;
  }
  return quantum;
}

double noiseLevel(std::span<const double> values) {
  if (values.size() < 3) return 0.0;
  std::vector<double> bends;
  bends.reserve(values.size());
  for (std::size_t i = 1; i + 1 < values.size(); ++i) {
    bends.push_back(values[i - 1] - 2.0 * values[i] + values[i + 1]);
  }
  // The variance of a second difference of white noise is 1 + 4 + 1 times the noise's.
  return std::max(robustDeviation(std::move(bends)) / std::sqrt(6.0), quantumOf(values) / 4.0);
}

std::vector<Block> runsAt(std::span<const double> values, double value) {
  std::vector<Block> runs;
  for (std::size_t i = 0; i < values.size(); ++i) {
    if (values[i] != value) continue;
    if (runs.empty() || runs.back().end != i) runs.push_back({i, i});
    runs.back().end = i + 1;
  }
  return runs;
}

bool comesByCounts(std::span<const double> values, double end, std::size_t least) {
  std::vector<double> levels(values.begin(), values.end());
  std::ranges::sort(levels);
  const double count = 1.5 * quantumOf(levels);
  std::size_t come = 0, by_counts = 0;
  for (const Block& run : runsAt(values, end)) {
    if (run.begin == 0 || run.size() < least) continue;
    ++come;
    if (std::abs(values[run.begin - 1] - end) <= count) ++by_counts;
  }
  return come > 0 && 2 * by_counts > come;
}

}  // namespace simgap
