#include "simgap/measure/logs/spikes.h"

#include <algorithm>
#include <cmath>

#include "simgap/core/blocks.h"
#include "simgap/core/statistics.h"
#include "simgap/measure/logs/resolution.h"

namespace simgap {
namespace {

constexpr double kSpikeSizes = 12.0;  // of the usual distance from the line between the neighbours
constexpr std::size_t kNear = 12;     // rows on either side that say what is usual here

/// Distance of row i from the line between its neighbours.
double bendAt(std::span<const double> time, std::span<const double> values, std::size_t i) {
  const double part = (time[i] - time[i - 1]) / (time[i + 1] - time[i - 1]);
  return values[i] - (values[i - 1] + part * (values[i + 1] - values[i - 1]));
}

}  // namespace

std::vector<std::size_t> findSpikes(std::span<const double> time, std::span<const double> values) {
  const std::size_t n = values.size();
  if (n < 2 * kNear) return {};
  std::vector<double> bend(n, 0.0), sizes;
  for (std::size_t i = 1; i + 1 < n; ++i) {
    bend[i] = bendAt(time, values, i);
    sizes.push_back(std::abs(bend[i]));
  }
  const double usual = std::max(upperMedian(sizes), 0.5 * quantumOf(values));
  std::vector<std::size_t> spikes;
  for (std::size_t i = 2; i + 2 < n; ++i) {
    const double size = std::abs(bend[i]);
    if (size <= kSpikeSizes * usual) continue;
    // A sample that is wrong by d bends its own row by d and each neighbour's by -d / 2.
    const double half = -0.5 * bend[i];
    const bool alone = std::abs(bend[i - 1] - half) < 0.3 * size && std::abs(bend[i + 1] - half) < 0.3 * size;
    if (!alone) continue;
    // Fast motion and jumps bend their surroundings, too.
    std::vector<double> near;
    for (std::size_t k = i > kNear ? i - kNear : 1; k < std::min(n - 1, i + kNear + 1); ++k) {
      if (k + 1 < i || k > i + 1) near.push_back(std::abs(bend[k]));
    }
    if (size > kSpikeSizes * upperMedian(std::move(near))) spikes.push_back(i);
  }
  return spikes;
}

std::vector<std::size_t> repairSpikes(std::span<const double> time, const std::vector<int>& session,
                                      std::span<double> values) {
  std::vector<std::size_t> rows;
  for (const Block& b : splitRows(session, values.size())) {
    const std::span<const double> own_time = time.subspan(b.begin, b.size());
    const std::span<double> own = values.subspan(b.begin, b.size());
    for (const std::size_t i : findSpikes(own_time, own)) {
      own[i] -= bendAt(own_time, own, i);
      rows.push_back(b.begin + i);
    }
  }
  return rows;
}

}  // namespace simgap
