/// \file
/// A mass at a point of a body that the model does not have: (m, m c, I) grows by (m, m c, m (|c|^2 1 - c c^T)). In
/// terms of m and m c all but the inertia is linear; what the point's inertia does follows from where it was found.
#include "diagnose/robots/robot_cause.h"

namespace simgap::robot_causes::payload {
namespace {

using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr char kName[] = "payload";
constexpr double kFarthest = 1.5;  // [m] from the body's origin: nothing hangs farther
constexpr double kLeast = 0.01;    // [kg] of which a centre can be said

VectorXd pointMass(const RobotRegressor& regressor, std::size_t body, const VectorXd& theta) {
  const double mass = theta[0];
  const Vector3d moment = theta.segment<3>(1);
  Matrix3d inertia = Matrix3d::Zero();
  if (std::abs(mass) > kLeast && moment.norm() < kFarthest * std::abs(mass)) {
    inertia = (moment.squaredNorm() * Matrix3d::Identity() - moment * moment.transpose()) / mass;
  }
  VectorXd change = VectorXd::Zero(regressor.columns());
  change.segment(regressor.bodyColumn(body), kBodyParameters) << mass, moment, inertia(0, 0), inertia(0, 1),
      inertia(0, 2), inertia(1, 1), inertia(1, 2), inertia(2, 2);
  return change;
}

/// Mass and centre.
VectorXd centred(const VectorXd& theta, MatrixXd& slopes) {
  VectorXd shown = theta;
  slopes = MatrixXd::Identity(4, 4);
  if (std::abs(theta[0]) <= kLeast) return shown;
  shown.tail<3>() /= theta[0];
  slopes.bottomRightCorner<3, 3>() /= theta[0];
  slopes.bottomLeftCorner<3, 1>() = -shown.tail<3>() / theta[0];
  return shown;
}

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  const RobotRegressor& regressor = rows.regressor();
  return onEveryBody(rows, kName, [&regressor](std::size_t b, RobotHypothesis& h) {
    h.sentence = "the body carries a mass that the model does not have";
    h.separates = "the same motion with the load taken off, or with a known mass at another place of the body";
    h.parameters = {{{"mass", "kg", -500.0, 500.0}, 1e-3},
                    {{"mc_x", "kg_m"}, 1e-3},
                    {{"mc_y", "kg_m"}, 1e-3},
                    {{"mc_z", "kg_m"}, 1e-3}};
    h.shown_as = {{{"mass", "kg"}}, {{"centre_x", "m"}}, {{"centre_y", "m"}}, {{"centre_z", "m"}}};
    h.linear = false;
    h.change = [&regressor, b](const VectorXd& theta) { return pointMass(regressor, b, theta); };
    h.counts = [](const VectorXd& theta) {
      return std::abs(theta[0]) > kLeast && theta.tail<3>().norm() < kFarthest * std::abs(theta[0]);
    };
    h.shown = centred;
  });
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::payload
