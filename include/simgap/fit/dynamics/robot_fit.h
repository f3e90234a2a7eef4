/// \file
/// From a robot's file and its log to a robot that was found, and what that is worth on rows it has not seen.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/dynamics/dynamics_fit.h"
#include "simgap/fit/dynamics/robot_model.h"
#include "simgap/fit/dynamics/torque_constants.h"

namespace simgap {

struct RobotFitOptions {
  std::string law = "coulomb";
  std::optional<std::vector<double>> torque_constants;  ///< shape (N) [N m/A]; of a log of currents only
  std::optional<KnownPayload> payload;  ///< that some sessions carry: currents with and without it tell the constants
};

struct RobotFit {
  RobotModel model;
  DynamicsFit fit;
  HeldOutErrors heldout;                   ///< over blocks
  std::optional<HeldOutErrors> over_logs;  ///< over sessions, where there are several
  std::vector<std::string> names, units;   ///< of all parameters
  std::vector<std::string> without_effect;
  std::vector<Estimate> constants;  ///< shape (N) where they were found
  ExtraColumn load;                 ///< shape (N)(rows): torques of the known payload; empty: none
  std::vector<std::string> warnings;
};

/// \throws ConfigError: currents without constants or a known payload, constants of another number or beside torques;
/// DataError: too short a log, nothing that moves, gravity that the log contradicts; NumericsError: the search did not
/// converge, or a joint hardly feels the payload
RobotFit fitRobot(const ArmModel& arm, const RobotLog& log, const RobotFitOptions& options);

/// What fitRobot() refuses before it fits. \throws ConfigError, DataError: as there
void requireRobotLog(const ArmModel& arm, const RobotLog& log, const RobotFitOptions& options);

}  // namespace simgap
