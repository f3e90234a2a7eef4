/// Mean of rotations: F. L. Markley, Y. Cheng, J. L. Crassidis, Y. Oshman, "Averaging quaternions", Journal of
/// Guidance, Control, and Dynamics 30(4), 2007: the eigenvector of sum(q q^T) with the largest eigenvalue.
#include "simgap/core/rotation.h"

#include <Eigen/Eigenvalues>
#include <cassert>
#include <cmath>

namespace simgap {

double geodesicAngle(const Eigen::Quaterniond& a, const Eigen::Quaterniond& b) {
  // arccos loses half the digits near 0; atan2 keeps them, and takes quaternions that are unit only nearly.
  const Eigen::Quaterniond b_from_a = a.conjugate() * b;
  return 2.0 * std::atan2(b_from_a.vec().norm(), std::abs(b_from_a.w()));
}

double jointError(JointType type, const JointPosition& a, const JointPosition& b) {
  return type == JointType::kSpherical ? geodesicAngle(a.rotation, b.rotation) : std::abs(a.angle - b.angle);
}

Eigen::Quaterniond meanRotation(std::span<const Eigen::Quaterniond> rotations) {
  assert(!rotations.empty());
  Eigen::Matrix4d sum = Eigen::Matrix4d::Zero();
  // q and -q give the same outer product, so their signs need no care.
  for (const Eigen::Quaterniond& rotation : rotations) sum += rotation.coeffs() * rotation.coeffs().transpose();
  const Eigen::SelfAdjointEigenSolver<Eigen::Matrix4d> solver(sum);
  Eigen::Quaterniond mean(Eigen::Vector4d(solver.eigenvectors().col(3)));
  if (mean.w() < 0.0) mean.coeffs() = -mean.coeffs();
  return mean.normalized();
}

Eigen::Matrix3d cross(const Eigen::Vector3d& v) {
  Eigen::Matrix3d m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

}  // namespace simgap
