/// \file
/// What the log of all joints says is missing in a robot's model: what a drive does on top of the rigid-body coupling,
/// and what the bodies themselves, their frames, their constants or their clocks have wrong. Everything works on sums
/// of the log (dynamics_sums.h): a hypothesis is one or a few columns beside the base parameters.
#pragma once

#include <algorithm>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/diagnose/diagnosis.h"
#include "simgap/fit/dynamics/robot_model.h"

namespace simgap {

struct RobotDiagnosisOptions : DiagnosisOptions {
  int max_causes = 4;
  double least_gain = 0.015;  ///< of the squared error of the joints on which a cause acts
  double holdout = 0.25;      ///< fraction of the blocks that only measure the gain
  /// \throws ConfigError: a cause that does not exist, with those that do.
  void validate() const;
};

/// A joint's error on data never used, relative to its effort; nan where it does not move there.
struct JointVerdict {
  std::string joint, unit;
  double given = 0.0;   ///< of the robot as it was given; nan where its bodies were to be found first
  double before = 0.0;  ///< with what the log itself says of its parameters
  double after = 0.0;   ///< with the causes
  /// Its squared error with the causes, over what was left of it on data that the robot was not fitted to when it was
  /// found (RobotModel::heldout_sd), or over the noise between neighbouring rows where that is more; nan where nobody
  /// has written the first down.
  double times_known = 0.0;
};

/// What is left in a joint on which no named cause acts.
struct LeftAtJoint {
  std::string joint;
  double share;  ///< of the joint's own squared error
  std::vector<Leftover> channels;
};

struct RobotDiagnosis {
  Diagnosis diagnosis;
  std::vector<JointVerdict> joints;
  std::vector<LeftAtJoint> elsewhere;
  std::optional<RobotModel> extended;  ///< the robot with those causes that its file can hold; none: it holds none
  std::vector<std::string> not_held;   ///< causes that it cannot hold
  Eigen::MatrixXd before, after;       ///< shape (rows, N): predicted efforts, in the log's unit
};

/// \param known  the robot's base parameters are known from another log (RobotModel::base_covariance): what this log
/// says beyond that is a cause. Otherwise they are fitted to this very log, and what they can absorb cannot be named.
/// \throws ConfigError, DataError: as requireRobotLog(), and the log of another robot; InterruptedError
RobotDiagnosis diagnoseRobot(const RobotModel& robot, RobotLog log, const RobotDiagnosisOptions& options,
                             const DiagnosisProgress& progress);

}  // namespace simgap
