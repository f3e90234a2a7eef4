#include "support/robot_logs.h"

#include "simgap/exchange/exchange.h"

namespace simgap::test {

ArmModel drawnArm(const reality::Robot& robot, std::uint64_t draw) {
  return readUrdf(reality::drawnUrdf(robot, draw), "robot.urdf").model;
}

RobotLog robotLog(const ArmModel& arm, const std::string& csv) {
  return readRobotLog(CsvTable::parse(csv, "log.csv"), loggedJoints(arm));
}

RobotLog robotLog(const RobotModel& model, const std::string& csv) {
  return readRobotLog(CsvTable::parse(csv, "log.csv"), loggedJoints(model));
}

std::vector<std::size_t> linksOfJoints(const ArmModel& arm) {
  std::vector<std::size_t> links;
  for (const Joint& joint : arm.joints) links.push_back(std::stoul(joint.name.substr(1)) - 1);
  return links;
}

Eigen::VectorXd trueParameters(const reality::Robot& robot, const ArmModel& arm) {
  const RobotRegressor regressor(arm, friction::find("coulomb"));
  Eigen::VectorXd all = Eigen::VectorXd::Zero(regressor.columns());
  const std::vector<std::size_t> links = linksOfJoints(arm);
  for (std::size_t k = 0; k < links.size(); ++k) {  // a tree's bodies and joints stand in one order
    const reality::RobotLink& link = robot.links[links[k]];
    // By Huygens and Steiner about the origin of the link.
    const Eigen::Vector3d& c = link.centre;
    const Eigen::Matrix3d i =
        link.inertia + link.mass * (c.squaredNorm() * Eigen::Matrix3d::Identity() - c * c.transpose());
    all.segment<kBodyParameters>(regressor.bodyColumn(k)) << link.mass, link.mass * c.x(), link.mass * c.y(),
        link.mass * c.z(), i(0, 0), i(0, 1), i(0, 2), i(1, 1), i(1, 2), i(2, 2);
    all[regressor.offsetColumn(k)] = link.offset;
    all[regressor.frictionColumn(k)] = link.coulomb;
    all[regressor.frictionColumn(k) + 1] = link.viscous;
    all[regressor.rotorColumn(k)] = link.rotor;
  }
  return all;
}

Eigen::VectorXd trueBase(const reality::Robot& robot, const ArmModel& arm) {
  const RobotRegressor regressor(arm, friction::find("coulomb"));
  return baseParameters(regressor, arm).combination * trueParameters(robot, arm);
}

}  // namespace simgap::test
