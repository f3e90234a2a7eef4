/// \file
/// Robots of tests/reality as arms, and their logs.
#pragma once

#include <Eigen/Core>
#include <string>

#include "reality/robot_rig.h"
#include "simgap/fit/dynamics/robot_model.h"

namespace simgap::test {

/// As drawnUrdf draws it.
ArmModel drawnArm(const reality::Robot& robot, std::uint64_t draw);
/// The link of the robot that each joint of the arm moves: a reader goes through a tree in an order of its own.
std::vector<std::size_t> linksOfJoints(const ArmModel& arm);
RobotLog robotLog(const ArmModel& arm, const std::string& csv);
RobotLog robotLog(const RobotModel& model, const std::string& csv);
/// What the robot's base parameters are, with the law `coulomb`, shape (K).
Eigen::VectorXd trueBase(const reality::Robot& robot, const ArmModel& arm);
/// The same as all parameters, shape (P), in the order of RobotRegressor.
Eigen::VectorXd trueParameters(const reality::Robot& robot, const ArmModel& arm);

}  // namespace simgap::test
