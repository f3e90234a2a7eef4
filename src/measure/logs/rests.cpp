#include "simgap/measure/logs/rests.h"

#include <algorithm>
#include <cmath>
#include <cstddef>

#include "simgap/core/statistics.h"

namespace simgap {

std::vector<bool> findRests(std::span<const double> time, std::span<const double> velocity,
                            std::span<const int> session, const RestRule& rule) {
  std::vector<bool> rest(velocity.size(), false);
  for (std::size_t begin = 0, end = 0; begin < velocity.size(); begin = std::max(end, begin + 1)) {
    for (end = begin; end < velocity.size() && session[end] == session[begin] && std::abs(velocity[end]) <= rule.slow;)
      ++end;
    if (end - begin < rule.fewest_rows || time[end - 1] - time[begin] < rule.least_seconds) continue;
    for (std::size_t i = begin; i < end; ++i) rest[i] = true;
    for (std::size_t i = begin; i-- > 0 && session[i] == session[begin];) {
      if (time[begin] - time[i] > rule.blurred_seconds) break;
      rest[i] = true;
    }
    for (std::size_t i = end; i < velocity.size() && session[i] == session[begin]; ++i) {
      if (time[i] - time[end - 1] > rule.blurred_seconds) break;
      rest[i] = true;
    }
  }
  return rest;
}

double fastSpeed(std::span<const double> velocity) {
  std::vector<double> speeds(velocity.begin(), velocity.end());
  for (double& speed : speeds) speed = std::abs(speed);
  return speeds.empty() ? 0.0 : quantile(std::move(speeds), 0.95);
}

double restingSpeed(std::span<const double> velocity, double dead_band) {
  constexpr double kCreep = 2e-3;  // of the fastest rows' speed
  return std::max(dead_band, kCreep * fastSpeed(velocity));
}

}  // namespace simgap
