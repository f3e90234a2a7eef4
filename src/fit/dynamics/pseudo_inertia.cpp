#include "simgap/fit/dynamics/pseudo_inertia.h"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "simgap/core/decompositions.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Matrix4d;
using Eigen::Vector3d;

/// pi of a pseudo-inertia: I = tr(S) 1 - S. Linear, so it takes derivatives to derivatives.
BodyParameters fromPseudo(const Matrix4d& j) {
  BodyParameters pi;
  pi << j(3, 3), j(0, 3), j(1, 3), j(2, 3), j(1, 1) + j(2, 2), -j(0, 1), -j(0, 2), j(0, 0) + j(2, 2), -j(1, 2),
      j(0, 0) + j(1, 1);
  return pi;
}

Matrix3d inertiaOf(const BodyParameters& pi) {
  Matrix3d inertia;
  inertia << pi[4], pi[5], pi[6], pi[5], pi[7], pi[8], pi[6], pi[8], pi[9];
  return inertia;
}

Matrix3d secondMoments(const Matrix3d& inertia) { return 0.5 * inertia.trace() * Matrix3d::Identity() - inertia; }

Matrix4d factorOf(const LogCholesky& theta) {
  Matrix4d u = Matrix4d::Zero();
  u(0, 0) = std::exp(theta[1]);
  u(1, 1) = std::exp(theta[2]);
  u(2, 2) = std::exp(theta[3]);
  u(0, 1) = theta[4];
  u(0, 2) = theta[5];
  u(1, 2) = theta[6];
  u(0, 3) = theta[7];
  u(1, 3) = theta[8];
  u(2, 3) = theta[9];
  u(3, 3) = 1.0;
  return std::exp(theta[0]) * u;
}

}  // namespace

BodyParameters bodyOf(const LogCholesky& theta, BodyJacobian* jacobian) {
  const Matrix4d u = factorOf(theta);
  if (jacobian != nullptr) {
    constexpr Index kPlaces[kBodyParameters][2] = {{3, 3}, {0, 0}, {1, 1}, {2, 2}, {0, 1},
                                                   {0, 2}, {1, 2}, {0, 3}, {1, 3}, {2, 3}};
    for (Index k = 0; k < kBodyParameters; ++k) {
      Matrix4d du = Matrix4d::Zero();
      const auto [row, column] = std::pair(kPlaces[k][0], kPlaces[k][1]);
      // e^a scales all of U; the other diagonals are exponentials, too.
      if (k == 0) {
        du = u;
      } else {
        du(row, column) = row == column ? u(row, column) : std::exp(theta[0]);
      }
      jacobian->col(k) = fromPseudo(du * u.transpose() + u * du.transpose());
    }
  }
  return fromPseudo(u * u.transpose());
}

LogCholesky logCholeskyOf(const BodyParameters& pi) {
  constexpr double kThinnest = 1e-3;  // [m]
  const double mass = pi[0];
  const Vector3d centre = pi.segment<3>(1) / mass;
  // S / m = C + c c^T, with C the second moments about the centre; C = R R^T with R upper triangular.
  Matrix3d about_centre = secondMoments(inertiaOf(pi)) / mass - centre * centre.transpose();
  const SymmetricEigen eigen = symmetricEigen(about_centre);
  const Vector3d moments = eigen.values.cwiseMax(kThinnest * kThinnest);
  about_centre = eigen.vectors * moments.asDiagonal() * eigen.vectors.transpose();
  // An upper factor is a lower one of the matrix turned round.
  const Matrix3d turned = about_centre.reverse();
  const Matrix3d lower = turned.llt().matrixL();
  const Matrix3d r = lower.reverse();
  LogCholesky theta;
  theta << 0.5 * std::log(mass), std::log(r(0, 0)), std::log(r(1, 1)), std::log(r(2, 2)), r(0, 1), r(0, 2), r(1, 2),
      centre;
  return theta;
}

double smallestMoment(const BodyParameters& pi) {
  Matrix4d j;
  j.topLeftCorner<3, 3>() = secondMoments(inertiaOf(pi));
  j.topRightCorner<3, 1>() = pi.segment<3>(1);
  j.bottomLeftCorner<1, 3>() = pi.segment<3>(1).transpose();
  j(3, 3) = pi[0];
  return symmetricEigen(j).values[0];
}

}  // namespace simgap
