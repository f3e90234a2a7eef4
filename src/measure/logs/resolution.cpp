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

}  // namespace simgap
