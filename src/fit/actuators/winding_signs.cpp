#include "simgap/fit/actuators/winding_signs.h"

#include <fmt/format.h>

#include <Eigen/Core>
#include <cmath>
#include <limits>
#include <vector>

#include "opposite_sign.h"

namespace simgap {

std::string oppositeWindingSign(std::span<const double> voltage, std::span<const double> current,
                                std::span<const double> velocity) {
  Eigen::Matrix4d sums = Eigen::Matrix4d::Zero();
  for (std::size_t i = 0; i < voltage.size(); ++i) {
    const Eigen::Vector4d row(current[i], velocity[i], 1.0, voltage[i]);
    sums.noalias() += row * row.transpose();
  }
  std::vector<LinearTerm> terms(3);
  terms.back().lower = -std::numeric_limits<double>::infinity();
  const auto rmsWith = [&](double of_current, double of_velocity) {
    const double cost = costTurned(sums, Eigen::Vector4d(of_current, of_velocity, 1.0, 1.0), terms);
    return std::sqrt(std::max(cost, 0.0) / static_cast<double>(voltage.size()));
  };
  const double as_it_is = rmsWith(1.0, 1.0), turned_current = rmsWith(-1.0, 1.0), turned_velocity = rmsWith(1.0, -1.0);
  const bool of_current = turned_current < turned_velocity;
  const double turned = of_current ? turned_current : turned_velocity;
  if (!(turned * turned < kOtherSign * as_it_is * as_it_is)) return {};
  const char* channel = of_current ? "current_A" : "velocity_rad_s";
  return fmt::format(
      "the {} has the opposite sign: turned round, a winding explains the voltage to {:.3g} V, as it is to {:.3g}; {}",
      channel, turned, as_it_is, turnItRound(channel));
}

}  // namespace simgap
