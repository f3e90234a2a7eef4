/// \file
/// A robot whose bodies and drives were found from a log, and its file: `format: simgap/dynamics/1`.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/fit/dynamics/robot_regressor.h"
#include "simgap/measure/logs/robot_log.h"

namespace simgap {

struct RobotModel {
  ArmModel arm;
  std::string law = "coulomb";
  bool currents = false;                 ///< it predicts currents instead of torques
  std::vector<double> torque_constants;  ///< shape (N) [N m/A]; empty without currents
  std::vector<StribeckCurve> curves;     ///< shape (N)
  Eigen::VectorXd parameters, sd;        ///< shape (P), in the order of RobotRegressor
  Eigen::MatrixXd base_covariance;       ///< shape (K, K): how well its base parameters are known; empty: not at all
  /// Shape (N): deviation that it leaves in each joint's effort on data it was not fitted to, in the log's unit; empty:
  /// nobody has looked.
  std::vector<double> heldout_sd;
  std::vector<double> presliding;  ///< shape (N): LoggedJoint::presliding, of the log it was found in; empty: not known
  std::string data_file, data_sha256;
};

/// A robot whose drives are unknown: its bodies as they stand, no friction beyond what its joints have.
/// \throws ConfigError as RobotRegressor
RobotModel robotModelOf(const ArmModel& arm);

std::string writeRobotModel(const RobotModel& model);
/// \throws ConfigError: also when its parameters are not those of its robot
RobotModel readRobotModel(const YamlNode& root);

/// The joints whose channels a log has to hold: those that follow no other. \throws ConfigError: a ball
std::vector<LoggedJoint> loggedJoints(const ArmModel& arm);
/// With what is known of their friction.
std::vector<LoggedJoint> loggedJoints(const RobotModel& model);

/// Effort of every joint in every row of a log, shape (rows, N), in the model's unit.
Eigen::MatrixXd predictEfforts(const RobotModel& model, const RobotLog& log);

/// |predicted - measured| / |measured| of a joint over the rows in which it moves.
double relativeError(const RobotLog& log, std::size_t joint, const Eigen::MatrixXd& predicted);

}  // namespace simgap
