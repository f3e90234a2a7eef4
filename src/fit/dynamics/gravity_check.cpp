// What the log's torques say about gravity, with the file's bodies: per joint
//
//     e = sum_k g_k G_k(q) + a tau_0(q, dq, ddq) + own friction,   k = x, y, z,
//
// where G_k is what the bodies of the file weigh under a unit of gravity along k, and tau_0 their torque without any.
#include "gravity_check.h"

#include <algorithm>
#include <cmath>

#include "simgap/core/decompositions.h"
#include "simgap/fit/dynamics/robot_fit.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr std::size_t kMostRows = 3000;
constexpr double kGravityShare = 0.3;  // share of what the other columns leave that gravity has to explain

/// Columns of each joint: gravity along x, y, z, the rest of the bodies' torque, sign, velocity, 1, and its effort.
std::vector<MatrixXd> gravityRows(const ArmModel& arm, const RobotLog& log) {
  const InverseDynamics dynamics(arm);
  InverseDynamics::Workspace work = dynamics.workspace();
  const Index n = std::ssize(dynamics.joints());
  RegressorMatrix y(n, dynamics.parameters());
  const VectorXd pi = dynamics.parametersOf(arm);
  const std::vector<double> still(dynamics.joints().size(), 0.0);
  const std::size_t stride = std::max<std::size_t>(1, log.rows() / kMostRows);
  std::vector<std::vector<Eigen::Matrix<double, 8, 1>>> rows(log.joints.size());
  for (std::size_t i = 0; i < log.rows(); i += stride) {
    if (!log.usable[i]) continue;
    const RobotMotion motion = motionAt(log, i);
    MatrixXd torque(n, 4);
    for (Index k = 0; k < 3; ++k) {
      dynamics.regressor(motion.position, still, still, Vector3d::Unit(k), work, y);
      torque.col(k) = y * pi;
    }
    dynamics.regressor(motion.position, motion.velocity, motion.acceleration, Vector3d::Zero(), work, y);
    torque.col(3) = y * pi;
    for (std::size_t c = 0; c < log.joints.size(); ++c) {
      const RobotJointLog& joint = log.joints[c];
      if (!joint.moves[i]) continue;
      Eigen::Matrix<double, 8, 1> row;
      row << torque.row(c).transpose(), joint.direction[i], joint.velocity[i], 1.0, joint.effort[i];
      rows[c].push_back(row);
    }
  }
  std::vector<MatrixXd> matrices;
  for (const auto& joint : rows) {
    MatrixXd& m = matrices.emplace_back(std::ssize(joint), 8);
    for (Index i = 0; i < m.rows(); ++i) m.row(i) = joint[i].transpose();
  }
  return matrices;
}

/// What is left of columns when others have taken their part.
MatrixXd without(const MatrixXd& columns, const MatrixXd& others) {
  MatrixXd a = others.transpose() * others;
  a.diagonal().array() += 1e-10 * a.diagonal().maxCoeff() + 1e-300;
  return columns - others * solveLeastSquares(a, others.transpose() * columns);
}

/// Whether a joint's effort follows the stated gravity: it explains much, and nearly all that any gravity could.
bool follows(const Vector3d& stated, const MatrixXd& weights, const MatrixXd& effort) {
  constexpr double kNearlyAll = 0.8;
  const VectorXd pull = weights * stated;
  const double along = pull.dot(effort.col(0)), size = effort.squaredNorm();
  if (!(along > 0.0)) return false;
  const double explained = along * along / pull.squaredNorm(), most = size - without(effort, weights).squaredNorm();
  return explained >= kGravityShare * size && explained >= kNearlyAll * most;
}

}  // namespace

std::optional<LoggedGravity> gravityOfLog(const ArmModel& arm, const RobotLog& log) {
  constexpr double kClear = 0.02;  // of the stiffest direction: one that no joint feels stays open
  Eigen::Matrix3d normal = Eigen::Matrix3d::Zero();
  Vector3d right = Vector3d::Zero(), torque = Vector3d::Zero();
  double squares = 0.0;
  for (const MatrixXd& rows : gravityRows(arm, log)) {
    if (rows.rows() < 20) continue;
    const MatrixXd left = without(rows(Eigen::all, {0, 1, 2, 7}), rows.middleCols(3, 4));
    const double size = left.col(3).squaredNorm(), pull = left.leftCols(3).squaredNorm();
    if (!(size > 0.0) || !(pull > 1e-6 * rows.leftCols(3).squaredNorm())) continue;
    // What lies on the robot besides its bodies, a cable say, may outweigh gravity in light joints, not in those that
    // carry the arm.
    if (follows(arm.gravity, left.leftCols(3), left.col(3))) return std::nullopt;
    // Of each joint the direction alone: its effort may be a current, and masses may be wrong.
    const double scale = std::sqrt(pull / size);
    const Vector3d along = left.leftCols(3).transpose() * left.col(3) / pull;
    normal += left.leftCols(3).transpose() * left.leftCols(3) / pull;
    right += scale * along;
    torque += along;
    squares += 1.0;
  }
  if (squares == 0.0) return std::nullopt;
  const SymmetricEigen eigen = symmetricEigen(normal);
  LoggedGravity found;
  for (Index k = 0; k < 3; ++k) {
    if (eigen.values[k] < kClear * eigen.values[2]) continue;
    const Vector3d v = eigen.vectors.col(k);
    found.direction += v * v.dot(right) / eigen.values[k];
    found.size += v * v.dot(torque) / eigen.values[k];
    found.felt += v * v.transpose();
  }
  if (found.direction.dot(right) < kGravityShare * squares) return std::nullopt;
  return found;
}

bool contradicts(const LoggedGravity& found, const Vector3d& gravity, bool currents) {
  constexpr double kFar = 0.5;      // cosine: 60 degrees
  constexpr double kHardly = 0.2;   // of gravity: so little of it that its direction says nothing
  constexpr double kClearly = 0.5;  // of gravity, that the log shows where the file has none: masses may be wrong
  const Vector3d part = found.felt * gravity;
  if (part.norm() >= kHardly * gravity.norm()) {
    return found.direction.normalized().dot(part.normalized()) <= kFar;
  }
  return !currents && found.size.norm() >= kClearly * gravity.norm();
}

}  // namespace simgap
