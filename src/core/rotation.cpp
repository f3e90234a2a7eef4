/// Mean of rotations: F. L. Markley, Y. Cheng, J. L. Crassidis, Y. Oshman, "Averaging quaternions", Journal of
/// Guidance, Control, and Dynamics 30(4), 2007: the eigenvector of sum(q q^T) with the largest eigenvalue.
///
/// Exponential, logarithm and Jacobians of SO(3): J. Sola, J. Deray, D. Atchuthan, "A micro Lie theory for state
/// estimation in robotics", 2018, eq. 133 and 143 f. Near the identity their series replace quotients of small numbers.
#include "simgap/core/rotation.h"

#include <cassert>
#include <cmath>
#include <numbers>

#include "simgap/core/decompositions.h"

namespace simgap {

Eigen::Quaterniond fromRollPitchYaw(const Eigen::Vector3d& rpy) {
  using Eigen::AngleAxisd, Eigen::Vector3d;
  return AngleAxisd(rpy.z(), Vector3d::UnitZ()) * AngleAxisd(rpy.y(), Vector3d::UnitY()) *
         AngleAxisd(rpy.x(), Vector3d::UnitX());
}

double geodesicAngle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  // arccos loses half the digits near 0; atan2 keeps them, and takes quaternions that are unit only nearly.
  const Eigen::Quaterniond b_from_a = a.conjugate() * b;
  return 2.0 * std::atan2(b_from_a.vec().norm(), std::abs(b_from_a.w()));
}

double hingeTurn(double from, double to) { return std::remainder(to - from, 2.0 * std::numbers::pi); }

Eigen::Quaterniond meanRotation(std::span<const Eigen::Quaterniond> rotations) {
  assert(!rotations.empty());
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  // q and -q give the same outer product, so their signs need no care.
  for (const Eigen::Quaterniond& rotation : rotations) sum += rotation.coeffs() * rotation.coeffs().transpose();
  Eigen::Quaterniond mean(Eigen::Vector4d(symmetricEigen(sum).vectors.col(3)));
  if (mean.w() < 0.0) mean.coeffs() = -mean.coeffs();
  return mean.normalized();
}

Eigen::Quaterniond rotationBetween(const Eigen::Vector3d& from, const Eigen::Vector3d& to) {
  // (cos(a/2), sin(a/2) axis) is (1 + cos a, sin a axis) but for its length.
  const double w = 1.0 + from.dot(to);
  const Eigen::Vector3d axis = w > 1e-12 ? from.cross(to) : from.unitOrthogonal();
  return Eigen::Quaterniond(w, axis.x(), axis.y(), axis.z()).normalized();
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Eigen::AngleAxisd expSo3(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  if (angle == 0.0) return Eigen::AngleAxisd::Identity();
  return {angle, w / angle};
}

Eigen::Quaterniond quaternionExpSo3(const Eigen::Vector3d& w) {
  const double square = w.squaredNorm();
  const double half = 0.5 * std::sqrt(square);
  const double sine = half > 1e-4 ? std::sin(half) / (2.0 * half) : 0.5 - square / 48.0;
  return Eigen::Quaterniond(std::cos(half), sine * w.x(), sine * w.y(), sine * w.z());
}

Eigen::Vector3d logSo3(const Eigen::Quaterniond& rotation) {
  // q = (cos(angle / 2), sin(angle / 2) axis); of q and -q the one with w >= 0 turns by at most pi.
  const double sine = rotation.vec().norm();
  const double sign = rotation.w() < 0.0 ? -1.0 : 1.0;
  if (sine < 1e-9) return 2.0 * sign * rotation.vec();
  return sign * 2.0 * std::atan2(sine, std::abs(rotation.w())) / sine * rotation.vec();
}

Eigen::Matrix3d rightJacobian(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  const Eigen::Matrix3d x = cross(w);
  // J_r = I - (1 - cos angle) / angle^2 [w]x + (angle - sin angle) / angle^3 [w]x^2
  if (angle < 1e-4) return Eigen::Matrix3d::Identity() - 0.5 * x + x * x / 6.0;
  return Eigen::Matrix3d::Identity() - (1.0 - std::cos(angle)) / (angle * angle) * x +
         (angle - std::sin(angle)) / (angle * angle * angle) * x * x;
}

Eigen::Matrix3d inverseRightJacobian(const Eigen::Vector3d& w) {
  const double angle = w.norm();
  // J_r^-1 = I + [w]x / 2 + (1 / angle^2 - (1 + cos angle) / (2 angle sin angle)) [w]x^2
  const double factor =
      angle < 1e-4 ? 1.0 / 12.0 : 1.0 / (angle * angle) - (1.0 + std::cos(angle)) / (2.0 * angle * std::sin(angle));
  const Eigen::Matrix3d x = cross(w);
  return Eigen::Matrix3d::Identity() + 0.5 * x + factor * x * x;
}

}  // namespace simgap
