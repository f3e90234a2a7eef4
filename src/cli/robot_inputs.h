/// \file
/// Robots and their logs, as several commands read them.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "simgap/cli/session.h"
#include "simgap/fit/dynamics/robot_model.h"

namespace simgap {

/// A robot's file in any format (arm, MJCF, URDF, SDF). \param gravity  "X,Y,Z" [m/s^2] instead of its own; empty: its
/// own. \throws ConfigError, DataError as readArm, readMjcf, readUrdf, readSdf
ArmModel readRobotFile(Session& session, const std::string& file, const std::string& gravity);

/// A robot's file, or what fit-dynamics has found; none for a model of one actuator.
std::optional<RobotModel> findRobotModel(Session& session, const std::string& file);

/// One or several logs of it, each a session. \throws DataError as readLog and readRobotLog
RobotLog readRobotLogs(Session& session, std::span<const LoggedJoint> joints, const std::vector<std::string>& files,
                       const LogFileOptions& options);

}  // namespace simgap
