/// \file
/// A joint's zero is not where the model has it: its position is q + delta.
#include "diagnose/robots/robot_cause.h"

namespace simgap::robot_causes::joint_offset {
namespace {

using Eigen::VectorXd;

constexpr char kName[] = "joint-offset";

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  return onEveryJoint(rows, kName, [&rows](std::size_t c, RobotHypothesis& h) {
    const bool slides = rows.joint(c).slides();
    h.sentence = "the joint's zero is not where the model has it";
    h.separates = "this joint driven against a mark or a stop whose position is known";
    h.parameters = {slides ? RobotCauseParameter{{"delta", "m", -0.5, 0.5}, 1e-3}
                           : RobotCauseParameter{{"delta", "rad", -0.8, 0.8}, 1e-2}};
    h.linear = false;
    h.torque = [&rows, c](const VectorXd& theta) {
      return onAll(rows.rigidChange(
          [&](std::size_t, RobotMotion& motion, Eigen::Vector3d&) { motion.position[c] += theta[0]; }));
    };
  });
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::joint_offset
