/// \file
/// Inside of the statics: where the links of an arm are. Templates, because the derivatives are complex steps.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <complex>
#include <vector>

#include "reality/arm_statics.h"

namespace simgap::reality {

template <typename Scalar>
using Vector3 = Eigen::Matrix<Scalar, 3, 1>;
template <typename Scalar>
using Matrix3 = Eigen::Matrix<Scalar, 3, 3>;
template <typename Scalar>
using Displacement = Eigen::Matrix<Scalar, Eigen::Dynamic, 1>;

// Complex step needs analytic functions: a product sum, never Eigen's dot() or norm(), which conjugate.
template <typename Scalar>
Scalar productSum(const Vector3<Scalar>& a, const Vector3<Scalar>& b) {
  return a.x() * b.x() + a.y() * b.y() + a.z() * b.z();
}

// exp of a rotation vector (Rodrigues), with the Taylor series of both coefficients near 0.
template <typename Scalar>
Matrix3<Scalar> rotationOf(const Vector3<Scalar>& w) {
  const Scalar square = productSum<Scalar>(w, w);
  Scalar sine = 1.0 - square / 6.0 * (1.0 - square / 20.0 * (1.0 - square / 42.0));
  Scalar versine = 0.5 - square / 24.0 * (1.0 - square / 30.0 * (1.0 - square / 56.0));
  if (std::abs(square) > 1e-3) {
    const Scalar angle = std::sqrt(square);
    sine = std::sin(angle) / angle;
    versine = (1.0 - std::cos(angle)) / square;
  }
  Matrix3<Scalar> cross;
  cross << Scalar(0.0), -w.z(), w.y(), w.z(), Scalar(0.0), -w.x(), -w.y(), w.x(), Scalar(0.0);
  return Matrix3<Scalar>::Identity() + sine * cross + versine * (cross * cross);
}

inline int freedoms(const Link& link) { return link.joint == Joint::kSpherical ? 3 : 1; }

inline int freedoms(const Arm& arm) {
  int sum = 0;
  for (const Link& link : arm.links) sum += freedoms(link);
  return sum;
}

// Where each link is. A displacement w moves a spherical joint to R exp(w), a revolute one to angle + w.
template <typename Scalar>
struct Placement {
  std::vector<Matrix3<Scalar>> world_from_link;
  std::vector<Vector3<Scalar>> origin;

  Placement(const Arm& arm, const Configuration& q, const Displacement<Scalar>& w)
      : world_from_link(arm.links.size()), origin(arm.links.size()) {
    int first = 0;
    for (std::size_t i = 0; i < arm.links.size(); ++i) {
      const Link& link = arm.links[i];
      Matrix3<Scalar> parent_from_link;
      if (link.joint == Joint::kSpherical) {
        parent_from_link = q[i].rotation.template cast<Scalar>() * rotationOf<Scalar>(w.template segment<3>(first));
      } else {
        parent_from_link = rotationOf<Scalar>(link.axis.template cast<Scalar>() * (q[i].angle + w[first]));
      }
      first += freedoms(link);
      const Vector3<Scalar> pivot = at({link.parent, link.joint_in_parent});
      world_from_link[i] =
          link.parent == kTorso ? parent_from_link : world_from_link[std::size_t(link.parent)] * parent_from_link;
      origin[i] = pivot - world_from_link[i] * link.joint_in_child.template cast<Scalar>();
    }
  }

  Vector3<Scalar> at(const Attachment& place) const {
    const Vector3<Scalar> point = place.point.template cast<Scalar>();
    if (place.link == kTorso) return point;
    return origin[std::size_t(place.link)] + world_from_link[std::size_t(place.link)] * point;
  }
};

// sqrt(a^2 + R^2 - 2 a R cos(alpha)) - R alpha: a straight piece from a point at distance a to the circle's point at
// angle alpha from it, less the arc that it saves. It is stationary where the piece is a tangent; by the envelope
// theorem the derivatives by `a` there are those at fixed alpha, so alpha may be found in real numbers. It is no
// minimum: beyond the tangent the piece would cut through the circle and be shorter still.
template <typename Scalar>
Scalar shortestToCircle(const Scalar& a, double radius) {
  double low = 0.0, high = 1.57079632679489662;
  for (int halving = 0; halving < 60; ++halving) {
    const double alpha = 0.5 * (low + high);
    (std::real(a) * std::cos(alpha) > radius ? low : high) = alpha;
  }
  const double alpha = 0.5 * (low + high);
  return std::sqrt(a * a + radius * radius - 2.0 * a * radius * std::cos(alpha)) - radius * alpha;
}

// Length of the line between two points that may not pass through the round body of the muscle.
template <typename Scalar>
Scalar lineLength(const Muscle& muscle, const Arm& arm, const Placement<Scalar>& placement) {
  const Vector3<Scalar> from = placement.at(muscle.from), to = placement.at(muscle.to);
  const Vector3<Scalar> line = to - from;
  const Scalar straight = std::sqrt(productSum<Scalar>(line, line));
  if (muscle.wrap_link == kTorso) return straight;
  const Link& link = arm.links[std::size_t(muscle.wrap_link)];
  const Vector3<Scalar> centre = placement.at({link.parent, link.joint_in_parent});
  Vector3<Scalar> p = from - centre, q = to - centre;
  Scalar along = 0.0;  // the cylinder's axis
  if (link.joint == Joint::kRevolute) {
    const Vector3<Scalar> axis =
        placement.world_from_link[std::size_t(muscle.wrap_link)] * link.axis.template cast<Scalar>();
    along = productSum<Scalar>(q - p, axis);
    p -= productSum<Scalar>(p, axis) * axis;
    q -= productSum<Scalar>(q, axis) * axis;
  }
  // Does the straight line come nearer to the centre than the radius, between its ends?
  const Vector3<Scalar> chord = q - p;
  const double way = -std::real(productSum<Scalar>(p, chord)) / std::real(productSum<Scalar>(chord, chord));
  const Vector3<Scalar> nearest = p + Scalar(way) * chord;
  const double distance = std::sqrt(std::real(productSum<Scalar>(nearest, nearest)));
  if (way <= 0.0 || way >= 1.0 || distance >= muscle.wrap_radius) return straight;
  const Scalar a = std::sqrt(productSum<Scalar>(p, p)), b = std::sqrt(productSum<Scalar>(q, q));
  const Scalar between = std::acos(productSum<Scalar>(p, q) / (a * b));
  const Scalar round = shortestToCircle<Scalar>(a, muscle.wrap_radius) +
                       shortestToCircle<Scalar>(b, muscle.wrap_radius) + muscle.wrap_radius * between;
  return std::sqrt(round * round + along * along);
}

template <typename Scalar>
Scalar cordExpansion(const Muscle& muscle, const Arm& arm, double shaft, const Placement<Scalar>& placement) {
  const double wound = muscle.spindle_radius * shaft + 0.5 * muscle.coiling * shaft * shaft;
  return lineLength<Scalar>(muscle, arm, placement) - muscle.kite_line + wound - muscle.cord_rest;
}

/// Largest rotation of a joint between two configurations [rad].
double largestRotation(const Arm& arm, const Configuration& a, const Configuration& b);

}  // namespace simgap::reality
