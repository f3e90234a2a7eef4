/// \file
/// What a log's torques say about gravity, as far as the joints feel it.
#pragma once

#include <Eigen/Core>
#include <optional>

#include "simgap/measure/logs/robot_log.h"
#include "simgap/model/arm/arm.h"

namespace simgap {

struct LoggedGravity {
  Eigen::Vector3d direction = Eigen::Vector3d::Zero();  ///< its length means nothing
  Eigen::Vector3d size = Eigen::Vector3d::Zero();       ///< [m/s^2] with the file's masses, where efforts are torques
  Eigen::Matrix3d felt = Eigen::Matrix3d::Zero();       ///< projects on the directions that any joint feels
};

/// In which direction the log's torques say that gravity pulls on the bodies of the file; none where they do not say it
/// clearly, or where a joint's effort follows the file's gravity about as well as any.
std::optional<LoggedGravity> gravityOfLog(const ArmModel& arm, const RobotLog& log);

/// Whether that is another gravity than the file's: of what joints feel of both, the directions are more than 60
/// degrees apart, or the log shows much where the file has almost nothing. \param currents  efforts are: their size is
/// unknown
bool contradicts(const LoggedGravity& found, const Eigen::Vector3d& gravity, bool currents);

}  // namespace simgap
