/// \file
/// Numbers of a robot or its motion, one after the other.
#pragma once

#include <Eigen/Geometry>
#include <cstdint>

#include "simgap/core/random.h"

namespace simgap::reality {

class RobotDraws {
 public:
  RobotDraws(std::uint64_t seed, std::uint32_t purpose) : random_(seed), purpose_(purpose) {}
  double normal() { return random_.normalPair({next_++, 0, 0, purpose_})[0]; }
  double between(double lower, double upper) {
    return lower + (upper - lower) * random_.uniform({next_++, 0, 1, purpose_});
  }
  Eigen::Vector3d direction() {
    const double x = normal(), y = normal(), z = normal();
    return Eigen::Vector3d(x, y, z).normalized();
  }
  Eigen::Vector3d inShell(double inner, double outer) {
    const Eigen::Vector3d way = direction();
    return between(inner, outer) * way;
  }
  Eigen::AngleAxisd turn(double largest) {
    const Eigen::Vector3d axis = direction();
    return Eigen::AngleAxisd(between(-largest, largest), axis);
  }

 private:
  CounterRandom random_;
  std::uint32_t purpose_, next_ = 0;
};

}  // namespace simgap::reality
