/// \file
/// How far a ball may tilt and twist: elastic stops beyond a swing and a twist.
///
/// With a the twist axis (unit, in the joint's frame), q = (p, u) the joint's rotation and v = u.a,
///
///   swing  s = angle between a and q a,      twist  t = 2 atan2(v, p),
///   V = k/2 (max(0, s - s_max)^2 + max(0, t - t_max)^2 + max(0, t_min - t)^2).
#pragma once

#include "simgap/model/arm/arm_effect.h"
#include "simgap/model/arm/joint.h"

namespace simgap {

/// Swing in [0, pi] and twist in (-pi, pi] of a ball [rad].
struct SwingTwist {
  double swing, twist;
};
SwingTwist swingTwist(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& axis);

/// Energy of the stops, its gradient and Hessian by a turn of the child, q -> q exp(w).
JointTerm ballStop(const BallStop& stop, const Eigen::Vector3d& axis, const Eigen::Quaterniond& rotation);

}  // namespace simgap
