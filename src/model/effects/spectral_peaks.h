/// \file
/// Where a spectrum is strongest: for ripples whose ratio is searched before it is fitted.
#pragma once

#include <Eigen/Core>
#include <algorithm>
#include <functional>
#include <numbers>
#include <utility>
#include <vector>

namespace simgap::actuator_effects {

/// Periods that the range of the angle holds at least. What is not seen to repeat is any function of the angle:
/// friction that is larger where a weight is lowered passed for a ripple of two periods, and a bias for a part of one.
inline constexpr double kFewestPeriods = 2.5;
inline bool repeats(double r, const Eigen::ArrayXd& angle) {
  return r * (angle.maxCoeff() - angle.minCoeff()) >= kFewestPeriods * 2.0 * std::numbers::pi;
}

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
