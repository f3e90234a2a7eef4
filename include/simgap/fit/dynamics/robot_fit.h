/// \file
/// From a robot's file and its log to a robot that was found, and what that is worth on rows it has not seen.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/dynamics/dynamics_fit.h"
#include "simgap/fit/dynamics/robot_model.h"

namespace simgap {

struct RobotFitOptions {
  std::string law = "coulomb";
  std::optional<std::vector<double>> torque_constants;  ///< shape (N) [N m/A]; of a log of currents only
};

struct RobotFit {
  RobotModel model;
  DynamicsFit fit;
  HeldOutErrors heldout;                   ///< over blocks
  std::optional<HeldOutErrors> over_logs;  ///< over sessions, where there are several
  std::vector<std::string> names, units;   ///< of all parameters
  std::vector<std::string> without_effect;
  std::vector<std::string> warnings;
};

/// \throws ConfigError: currents without constants, constants of another number or beside torques; DataError: too short
/// a log, nothing that moves, gravity that the log contradicts; NumericsError: the search did not converge
RobotFit fitRobot(const ArmModel& arm, const RobotLog& log, const RobotFitOptions& options);

/// What fitRobot() refuses before it fits. \throws ConfigError, DataError: as there
void requireRobotLog(const ArmModel& arm, const RobotLog& log, const RobotFitOptions& options);

}  // namespace simgap
