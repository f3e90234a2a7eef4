#include "velocity_scale.h"

#include <algorithm>
#include <cmath>

#include "simgap/core/rotation.h"

namespace simgap {

std::optional<VelocityScale> velocityScale(std::span<const double> time, std::span<const double> position,
                                           std::span<const double> velocity, std::span<const Block> runs) {
  constexpr std::size_t kHalf = 8;  // rows
  constexpr double kMoves = 0.02;   // [rad/s] or [m/s]
  double product = 0.0, of_slope = 0.0, of_velocity = 0.0;
  std::size_t count = 0;
  for (const Block& run : runs) {
    for (std::size_t i = run.begin + kHalf; i + kHalf < run.end; i += kHalf) {
      const double slope = (position[i + kHalf] - position[i - kHalf]) / (time[i + kHalf] - time[i - kHalf]);
      double mean = 0.0;
      for (std::size_t k = i - kHalf; k <= i + kHalf; ++k) mean += velocity[k] / (2.0 * kHalf + 1.0);
      product += slope * mean;
      of_slope += slope * slope;
      of_velocity += mean * mean;
      ++count;
    }
  }
  const auto n = static_cast<double>(count);
  if (count < kHalf || of_slope < n * kMoves * kMoves) return std::nullopt;  // it stands
  const double factor = product / of_slope, noise = std::max(of_velocity - factor * product, 0.0) / n;
  return VelocityScale{factor, std::sqrt(noise / of_slope)};
}

std::string degreesSlip(double factor, double share) {
  const auto near = [&](double value) { return std::abs(factor / value - 1.0) < share; };
  if (near(1.0 / kDegree)) return " (a velocity in degrees has a column that ends in _deg_s)";
  return near(kDegree) ? " (a position in degrees has a column that ends in _deg)" : "";
}

}  // namespace simgap
