/// \file
/// A mass at a point of a body, by its mass m and moment m c: what payloads say of the regressor's parameters.
#pragma once

#include <cmath>

#include "diagnose/robots/robot_cause.h"

namespace simgap::robot_causes {

inline constexpr double kFarthestLoad = 1.5;  // [m] from the body's origin: nothing hangs farther
inline constexpr double kLeastLoad = 0.01;    // [kg] of which a centre can be said

/// (m, m c, I) grows by (m, m c, m (|c|^2 1 - c c^T)), shape (P). In terms of m and m c all but the inertia is linear;
/// what the point's inertia does follows from where it was found. \param theta  (m, m c)
inline Eigen::VectorXd pointMass(const RobotRegressor& regressor, std::size_t body, const Eigen::VectorXd& theta) {
  const double mass = theta[0];
  const Eigen::Vector3d moment = theta.segment<3>(1);
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();
  if (std::abs(mass) > kLeastLoad && moment.norm() < kFarthestLoad * std::abs(mass)) {
    inertia = (moment.squaredNorm() * Eigen::Matrix3d::Identity() - moment * moment.transpose()) / mass;
  }
  Eigen::VectorXd change = Eigen::VectorXd::Zero(regressor.columns());
  change.segment(regressor.bodyColumn(body), kBodyParameters) << mass, moment, inertia(0, 0), inertia(0, 1),
      inertia(0, 2), inertia(1, 1), inertia(1, 2), inertia(2, 2);
  return change;
}

/// Mass and centre.
inline Eigen::VectorXd centred(const Eigen::VectorXd& theta, Eigen::MatrixXd& slopes) {
  Eigen::VectorXd shown = theta;
  slopes = Eigen::MatrixXd::Identity(4, 4);
  if (std::abs(theta[0]) <= kLeastLoad) return shown;
  shown.tail<3>() /= theta[0];
  slopes.bottomRightCorner<3, 3>() /= theta[0];
  slopes.bottomLeftCorner<3, 1>() = -shown.tail<3>() / theta[0];
  return shown;
}

/// Numbers of a payload, and what of them counts.
inline void describePointMass(RobotHypothesis& h) {
  h.parameters = {{{"mass", "kg", -500.0, 500.0}, 1e-3},
                  {{"mc_x", "kg_m"}, 1e-3},
                  {{"mc_y", "kg_m"}, 1e-3},
                  {{"mc_z", "kg_m"}, 1e-3}};
  h.shown_as = {{{"mass", "kg"}}, {{"centre_x", "m"}}, {{"centre_y", "m"}}, {{"centre_z", "m"}}};
  h.linear = false;
  h.counts = [](const Eigen::VectorXd& theta) {
    return std::abs(theta[0]) > kLeastLoad && theta.tail<3>().norm() < kFarthestLoad * std::abs(theta[0]);
  };
  h.shown = centred;
}

}  // namespace simgap::robot_causes
