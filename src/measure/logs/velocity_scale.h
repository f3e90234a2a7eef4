/// \file
/// What a measured velocity is to the slope of the position beside it: 1 time, or a slip of units.
#pragma once

#include <optional>
#include <span>
#include <string>

#include "simgap/core/blocks.h"

namespace simgap {

/// velocity = factor x slope + noise.
struct VelocityScale {
  double factor;
  double sd;  ///< of the factor, from that noise
};

/// Least squares over stretches of some rows; none where position hardly changes. \param time  [s], \param position,
/// velocity  shape (n). \param runs  as splitRuns
std::optional<VelocityScale> velocityScale(std::span<const double> time, std::span<const double> position,
                                           std::span<const double> velocity, std::span<const Block> runs);

/// " (a velocity in degrees has a column that ends in _deg_s)" where the factor is that of degrees, within a share;
/// empty where it is none.
std::string degreesSlip(double factor, double share);

}  // namespace simgap
