/// \file
/// What stands between a quantity and its column in a log: steps of a converter, noise that remembers.
#pragma once

#include <cmath>

namespace simgap::reality {

/// The nearest multiple of a step; the value itself without one.
inline double quantised(double value, double step) { return step > 0.0 ? step * std::round(value / step) : value; }

/// Noise of standard deviation `sd` whose neighbouring samples correlate by `memory` (AR(1)).
class ColouredNoise {
 public:
  ColouredNoise(double sd, double memory) : sd_(sd), memory_(memory) {}

  /// \param draw  of a standard normal distribution
  double next(double draw) {
    state_ = memory_ * state_ + std::sqrt(1.0 - memory_ * memory_) * draw;
    return sd_ * state_;
  }

 private:
  double sd_, memory_, state_ = 0.0;
};

}  // namespace simgap::reality
