/// \file
/// What causes that shift a channel in time share: where to search for the shift, and which size is one.
#pragma once

#include <cmath>
#include <span>
#include <vector>

#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::delays {

inline constexpr EffectParameter kDelay{"dt", "s", -0.5, 0.5, 0.0, 0.0};

/// Up to ten rows either way.
inline std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  std::vector<std::vector<double>> list;
  for (int k = -10; k <= 10; ++k) {
    const double delay = (k + 0.37) * rows.step;  // off the samples, where the derivative jumps
    if (std::abs(delay) < kDelay.upper) list.push_back({delay});
  }
  return list;
}

/// Where a reversal lies between two rows is not known better than to half a row, and a velocity from an encoder lags
/// by as much: such a delay is no finding, one of a whole row is.
inline bool counts(std::span<const double> p, const ActuatorRows& rows) { return std::abs(p[0]) >= 0.75 * rows.step; }

}  // namespace simgap::actuator_effects::delays
