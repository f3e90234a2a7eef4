/// \file
/// Where a spectrum is strongest: for ripples whose ratio is searched before it is fitted.
#pragma once

#include <algorithm>
#include <functional>
#include <utility>
#include <vector>

namespace simgap::actuator_effects {

/// Peaks of power(r) for r from `lowest` in steps up to `highest`, at most `most`. \returns their r, the strongest
/// first.
template <typename Power>
std::vector<double> strongestPeaks(double lowest, double highest, double step, std::size_t most, const Power& power) {
  std::vector<std::pair<double, double>> peaks;  // power, r
  double before = 0.0, last = 0.0, last_r = 0.0;
  for (double r = lowest; r < highest; r += step) {
    const double now = power(r);
    if (last > before && last > now) peaks.emplace_back(last, last_r);
    before = last;
    last = now;
    last_r = r;
  }
  std::ranges::sort(peaks, std::greater<>{}, &std::pair<double, double>::first);
  std::vector<double> ratios;
  for (std::size_t k = 0; k < std::min(peaks.size(), most); ++k) ratios.push_back(peaks[k].second);
  return ratios;
}

}  // namespace simgap::actuator_effects
