/// \file
/// A robot's log as sums: of each joint and block the products of all columns that act on it, of its known torque and
/// of its effort. Every fit, fold and interval that is linear or quadratic in them needs no other pass over the rows.
#pragma once

#include <Eigen/Core>
#include <span>
#include <vector>

#include "simgap/fit/dynamics/robot_regressor.h"
#include "simgap/measure/logs/robot_log.h"

namespace simgap {

/// Sums over some blocks for one joint whose base parameters are `acts` (A of them). With v = (-x, -1, k) of base
/// parameters x and a torque constant k the sum of squared errors k i - tau is v^T products v.
struct JointSums {
  Eigen::MatrixXd products;  ///< shape (A + 2, A + 2): columns, known torque, effort
  double rows = 0.0;

  double effortSquares() const { return products(products.rows() - 1, products.cols() - 1); }
  JointSums& operator+=(const JointSums& other) {
    products += other.products;
    rows += other.rows;
    return *this;
  }
};

/// A torque that something else adds, as a column behind the base parameters: of each joint, shape (N), its rows, shape
/// (rows); empty for a joint on which it does not act.
using ExtraColumn = std::vector<Eigen::ArrayXd>;

struct DynamicsSums {
  std::vector<std::vector<JointSums>> blocks;  ///< shape (blocks, N)

  /// Over some blocks, shape (N). \param used  shape (blocks)
  std::vector<JointSums> total(const std::vector<bool>& used) const;
};

/// Rows in which a joint moves, and all joints' motions are known, count for it. \throws InterruptedError
/// \param used  shape (blocks): others stay empty. \param extras  of each joint those that act on it stand in their
/// order between its base parameters and its known torque \param known  torques, shape (N)(rows), that are known
/// beside those of springs; empty: none
DynamicsSums sumDynamics(const RobotLog& log, const RobotRegressor& regressor, const BaseParameters& base,
                         std::span<const StribeckCurve> curves, const std::vector<bool>& used,
                         std::span<const ExtraColumn> extras = {}, const ExtraColumn& known = {});

/// Torque of every joint in the rows [begin, end), shape (end - begin, N), of all parameters p, shape (P).
Eigen::MatrixXd predictTorques(const RobotLog& log, const RobotRegressor& regressor, const Eigen::VectorXd& p,
                               std::span<const StribeckCurve> curves);

/// The moment `row` of a log.
RobotMotion motionAt(const RobotLog& log, std::size_t row);

}  // namespace simgap
