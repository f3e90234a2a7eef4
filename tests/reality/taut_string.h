/// \file
/// The shortest line between two points that stays out of a ball or a long cylinder, found without any geometry: a
/// string of many points, each pulled to the middle of its neighbours and pushed out of the obstacle, until nothing
/// moves.
#pragma once

#include <cmath>
#include <functional>
#include <vector>

#include <Eigen/Core>

namespace simgap::reality {

/// \param from_middle  of a point to the nearest point of the obstacle's middle (a centre, an axis) \param first  a
/// point that the string is laid over at first, which chooses its side  \returns its length; too short by about (angle
/// / points)^2 / 24 of the arc
inline double tautString(const Eigen::Vector3d& from, const Eigen::Vector3d& to, const Eigen::Vector3d& first,
                         double radius, const std::function<Eigen::Vector3d(const Eigen::Vector3d&)>& from_middle,
                         int points = 128) {
  std::vector<Eigen::Vector3d> string;
  for (int k = 0; k <= points; ++k) {
    const double s = 2.0 * k / points;
    string.push_back(s < 1.0 ? Eigen::Vector3d(from + s * (first - from))
                             : Eigen::Vector3d(first + (s - 1.0) * (to - first)));
  }
  const auto push = [&](Eigen::Vector3d& x) {
    const Eigen::Vector3d out = from_middle(x);
    if (out.norm() < radius) x += (radius / out.norm() - 1.0) * out;
  };
  const auto length = [&] {
    double sum = 0.0;
    for (int k = 0; k < points; ++k) sum += (string[k + 1] - string[k]).norm();
    return sum;
  };
  // Over-relaxed, as neighbours pull slowly on long strings.
  const double over = 2.0 / (1.0 + std::sin(3.14159265358979 / points));
  double before = length();
  for (int sweep = 1; sweep < 20000; ++sweep) {
    const double factor = sweep % 50 == 0 ? 1.0 : over;
    for (int k = 1; k < points; ++k) {
      string[k] += factor * (0.5 * (string[k - 1] + string[k + 1]) - string[k]);
      push(string[k]);
    }
    if (sweep % 200 != 0) continue;
    const double now = length();
    if (std::abs(now - before) < 1e-12) break;
    before = now;
  }
  return length();
}

}  // namespace simgap::reality
