#include "robot_rows.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/interrupt.h"
#include "simgap/measure/logs/stamps.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

ArrayXd arrayOf(const std::vector<double>& values) {
  return Eigen::Map<const ArrayXd>(values.data(), std::ssize(values));
}

double frictionSum(const RobotRegressor& regressor, const VectorXd& parameters, std::size_t c, FrictionBasis basis) {
  double sum = 0.0;
  Index at = regressor.frictionColumn(c);
  for (const FrictionTerm& term : regressor.law().terms) {
    if (term.basis == basis && term.shape != FrictionShape::kStatic) sum += parameters[at];
    ++at;
  }
  return sum;
}

}  // namespace

RobotRows::RobotRows(const RobotLog& log, const RobotModel& model, const RobotRegressor& regressor, VectorXd parameters,
                     const VectorXd& flat, const std::vector<bool>& training)
    : log_(log), model_(model), regressor_(regressor), parameters_(std::move(parameters)), training_(training) {
  for (std::size_t b = 0; b < regressor.bodies(); ++b) {
    if (regressor.massless(b)) parameters_.segment(regressor.bodyColumn(b), kBodyParameters).setZero();
  }
  torque_ = predictTorques(log, regressor, parameters_, model.curves);
  flat_torque_ = predictTorques(log, regressor, flat, model.curves);
  of_springs_ = predictTorques(log, regressor, VectorXd::Zero(flat.size()), model.curves);
  rigid_ = MatrixXd::Zero(std::ssize(log.time), std::ssize(log.joints));
  rigid_ = rigidChange([](std::size_t, RobotMotion&, Vector3d&) {});
  for (std::size_t c = 0; c < log.joints.size(); ++c) {
    const RobotJointLog& joint = log.joints[c];
    ActuatorRows& rows = drives_.emplace_back();
    rows.time = arrayOf(log.time);
    rows.effort = constant(c) * arrayOf(joint.effort);
    rows.speed = arrayOf(joint.velocity);
    rows.direction = rows.speed.unaryExpr([](double) { return 1.0; });
    for (std::size_t i = 0; i < log.rows(); ++i) rows.direction[i] = joint.direction[i];
    rows.acceleration = arrayOf(joint.acceleration);
    rows.joint_angle = arrayOf(joint.position);
    rows.load = rigid_.col(c).array();
    if (!joint.temperature.empty()) rows.temperature = arrayOf(joint.temperature);
    rows.travel = rows.rest = ArrayXd::Zero(rows.time.size());
    rows.session = log.session;
    rows.step = usualStep(log.time);
    rows.elapsed = elapsedOf(rows.time, rows.session);
    rows.top_speed = std::max(rows.speed.abs().maxCoeff(), 1e-9);
    rows.top_load = rows.load.abs().maxCoeff();
  }
}

MatrixXd RobotRows::torqueOf(const VectorXd& change) const {
  return predictTorques(log_, regressor_, change, model_.curves) - of_springs_;
}

ArrayXd RobotRows::residual(std::size_t c) const {
  ArrayXd left = drives_[c].effort - flat_torque_.col(c).array();
  for (std::size_t i = 0; i < log_.rows(); ++i) {
    if (!training_[i] || !counts(i, c)) left[i] = 0.0;
  }
  return left;
}

double RobotRows::coulomb(std::size_t c) const {
  return frictionSum(regressor_, parameters_, c, FrictionBasis::kDirection);
}
double RobotRows::viscous(std::size_t c) const {
  return frictionSum(regressor_, parameters_, c, FrictionBasis::kVelocity);
}

MatrixXd RobotRows::rigidChange(const Change& change) const {
  const InverseDynamics& dynamics = regressor_.dynamics();
  const VectorXd bodies = parameters_.segment(regressor_.bodyColumn(0), dynamics.parameters());
  MatrixXd torque(std::ssize(log_.time), std::ssize(log_.joints));
  tbb::parallel_for(std::size_t{0}, log_.blocks.size(), [&](std::size_t b) {
    if (interruptRequested()) return;
    InverseDynamics::Workspace work = dynamics.workspace();
    RegressorMatrix y(torque.cols(), dynamics.parameters());
    RobotMotion motion = motionAt(log_, 0);
    for (std::size_t row = log_.blocks[b].begin; row < log_.blocks[b].end; ++row) {
      for (std::size_t c = 0; c < joints(); ++c) motionAfter(c, row, 0.0, motion);
      Vector3d gravity = model_.arm.gravity;
      change(row, motion, gravity);
      dynamics.regressor(motion.position, motion.velocity, motion.acceleration, gravity, work, y);
      const auto i = static_cast<Index>(row);
      torque.row(i) = (y * bodies).transpose();
      for (Index c = 0; c < torque.cols(); ++c) {
        torque(i, c) += dynamics.springTorque(static_cast<std::size_t>(c), motion.position[c]);
      }
      torque.row(i) -= rigid_.row(i);
    }
  });
  stopIfInterrupted();
  return torque;
}

std::pair<std::size_t, double> RobotRows::momentAfter(std::size_t row, double later) const {
  const double moment = log_.time[row] + later;
  const auto same = [&](std::size_t other) { return log_.session[other] == log_.session[row]; };
  std::size_t i = row;
  while (i + 2 < log_.rows() && same(i + 2) && log_.time[i + 1] < moment) ++i;
  while (i > 0 && same(i - 1) && log_.time[i] > moment) --i;
  if (i + 1 >= log_.rows() || !same(i + 1)) return {i > 0 && same(i - 1) ? i - 1 : i, 1.0};
  const double share = (moment - log_.time[i]) / (log_.time[i + 1] - log_.time[i]);
  return {i, std::clamp(share, 0.0, 1.0)};
}

void RobotRows::motionAfter(std::size_t joint, std::size_t row, double later, RobotMotion& motion) const {
  const RobotJointLog& log = log_.joints[joint];
  if (later == 0.0) {
    motion.position[joint] = log.position[row];
    motion.velocity[joint] = log.velocity[row];
    motion.acceleration[joint] = log.acceleration[row];
    return;
  }
  const auto moment = momentAfter(row, later);
  const std::size_t next = std::min(moment.first + 1, log_.rows() - 1);
  // A structured binding cannot be captured by C++20's letter (clang 14 refuses it), a pair can.
  const auto between = [&](const std::vector<double>& values) {
    return (1.0 - moment.second) * values[moment.first] + moment.second * values[next];
  };
  motion.position[joint] = between(log.position);
  motion.velocity[joint] = between(log.velocity);
  motion.acceleration[joint] = between(log.acceleration);
}

ArrayXd RobotRows::shifted(const Eigen::Ref<const ArrayXd>& values, double later) const {
  ArrayXd result(values.size());
  for (std::size_t row = 0; row < log_.rows(); ++row) {
    const auto [i, share] = momentAfter(row, later);
    const std::size_t next = std::min(i + 1, log_.rows() - 1);
    result[row] = (1.0 - share) * values[i] + share * values[next];
  }
  return result;
}

}  // namespace simgap
