/// \file
/// Friction of a joint that grows with what the bodies ask of its neighbour in the tree: bearings and seals that share
/// a shaft, or a housing that bends: + n |tau_k| sign(dq_j).
#include <algorithm>

#include "diagnose/robots/robot_cause.h"
#include "simgap/model/arm/arm_tree.h"

namespace simgap::robot_causes::coupled_friction {
namespace {

using Eigen::VectorXd;

constexpr char kName[] = "coupled-friction";

/// The joint before a body's own, through bodies that are fixed to each other; -1: the base.
int coordinateBefore(const RobotRows& rows, std::size_t c) {
  const ArmModel& arm = rows.model().arm;
  const std::vector<int>& coordinates = rows.regressor().dynamics().joints();
  for (const int joint : jointsAbove(arm, arm.joints[coordinates[c]].parent)) {
    const auto found = std::ranges::find(coordinates, joint);
    if (found != coordinates.end()) return static_cast<int>(found - coordinates.begin());
  }
  return -1;
}

RobotHypothesis byNeighbour(const RobotRows& rows, std::size_t c, std::size_t k) {
  RobotHypothesis h;
  h.cause = kName;
  h.target = rows.jointName(c) + " by " + rows.jointName(k);
  h.drive = static_cast<int>(c);
  h.sentence = "friction of the first joint grows with the load of the second, its neighbour";
  h.separates = "slow motion of the first joint while the second holds different loads";
  const bool alike = rows.joint(c).slides() == rows.joint(k).slides();
  h.parameters = {{{"n", alike ? "1" : rows.joint(c).slides() ? "1_m" : "m", 0.0}}};
  h.torque = [&rows, c, k](const VectorXd& theta) {
    return onJoint(rows.joints(), c, theta[0] * rows.drive(k).load.abs() * rows.drive(c).direction);
  };
  return h;
}

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  std::vector<RobotHypothesis> list;
  for (std::size_t c = 0; c < rows.joints(); ++c) {
    const int before = coordinateBefore(rows, c);
    if (before < 0) continue;
    const auto k = static_cast<std::size_t>(before);
    list.push_back(byNeighbour(rows, c, k));
    list.push_back(byNeighbour(rows, k, c));
  }
  return list;
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::coupled_friction
