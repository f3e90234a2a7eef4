#include "simgap/model/arm/ball_stop.h"

#include <algorithm>
#include <cmath>
#include <numbers>

namespace simgap {
namespace {

constexpr double kNoDirection = 1e-9;  // a swing of none or of half a turn has no direction

struct Angle {
  double value;
  Eigen::Vector3d slope;
  Eigen::Matrix3d curvature;
};

void addStop(double stiffness, double beyond, double sign, const Angle& angle, JointTerm& term) {
  if (beyond <= 0.0) return;
  term.energy += 0.5 * stiffness * beyond * beyond;
  term.gradient += sign * stiffness * beyond * angle.slope;
  term.hessian += stiffness * (angle.slope * angle.slope.transpose() + sign * beyond * angle.curvature);
}

/// cos s = a.q a: with b = q^-1 a its slope is a x b, its curvature sym(a b^T) - cos s 1.
Angle swingOf(const Eigen::Quaterniond& q, const Eigen::Vector3d& a) {
  const Eigen::Vector3d b = q.conjugate() * a;
  const Eigen::Vector3d normal = a.cross(b);
  const double sine = normal.norm(), cosine = a.dot(b);
  Angle swing{std::atan2(sine, cosine), Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};
  if (sine < kNoDirection) return swing;
  swing.slope = -normal / sine;
  const Eigen::Matrix3d of_cosine =
      0.5 * (a * b.transpose() + b * a.transpose()) - cosine * Eigen::Matrix3d::Identity();
  swing.curvature = -of_cosine / sine - cosine / (sine * sine * sine) * normal * normal.transpose();
  return swing;
}

/// dv = w.(p a + a x u)/2, dp = -w.u/2; what both curve by cancels in the angle.
Angle twistOf(const Eigen::Quaterniond& q, const Eigen::Vector3d& a) {
  const double sign = q.w() < 0.0 ? -1.0 : 1.0;
  const double p = sign * q.w();
  const Eigen::Vector3d u = sign * q.vec();
  const double v = u.dot(a), square = p * p + v * v;
  Angle twist{2.0 * std::atan2(v, p), Eigen::Vector3d::Zero(), Eigen::Matrix3d::Zero()};
  if (square < kNoDirection) return twist;
  const Eigen::Vector3d dv = 0.5 * (p * a + a.cross(u)), dp = -0.5 * u;
  twist.slope = 2.0 / square * (p * dv - v * dp);
  const Eigen::Matrix3d mixed = dv * dp.transpose() + dp * dv.transpose();
  twist.curvature =
      (4.0 * p * v * (dp * dp.transpose() - dv * dv.transpose()) + 2.0 * (v * v - p * p) * mixed) / (square * square);
  return twist;
}

}  // namespace

SwingTwist swingTwist(const Eigen::Quaterniond& rotation, const Eigen::Vector3d& axis) {
  return {swingOf(rotation, axis).value, twistOf(rotation, axis).value};
}

JointTerm ballStop(const BallStop& stop, const Eigen::Vector3d& axis, const Eigen::Quaterniond& rotation) {
  JointTerm term;
  const Angle swing = swingOf(rotation, axis), twist = twistOf(rotation, axis);
  addStop(stop.stiffness, swing.value - stop.swing, 1.0, swing, term);
  addStop(stop.stiffness, twist.value - stop.upper_twist, 1.0, twist, term);
  addStop(stop.stiffness, stop.lower_twist - twist.value, -1.0, twist, term);
  return term;
}

}  // namespace simgap
