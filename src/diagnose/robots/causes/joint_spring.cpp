/// \file
/// Something elastic hangs at a joint, a hose, a harness, a spring that carries a weight: + k (q - q_mean). What it
/// pulls at the middle of the joint's motion is the effort's offset.
#include "diagnose/robots/robot_cause.h"

namespace simgap::robot_causes::joint_spring {
namespace {

using Eigen::VectorXd;

constexpr char kName[] = "joint-spring";

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  return onEveryJoint(rows, kName, [&rows](std::size_t c, RobotHypothesis& h) {
    const Eigen::ArrayXd& position = rows.drive(c).joint_angle;
    const double middle = position.mean();
    h.drive = static_cast<int>(c);
    h.sentence = "something elastic hangs at the joint: a hose, a harness, a spring";
    h.separates = "slow motion of this joint over its whole range, then again with hoses and cables taken off";
    h.parameters = {{{"k", rows.joint(c).slides() ? "N_m" : "Nm_rad", 0.0}}};
    h.torque = [&rows, &position, c, middle](const VectorXd& theta) {
      return onJoint(rows.joints(), c, theta[0] * (position - middle));
    };
    h.hold = [&rows, c, middle](const VectorXd& theta, RobotModel& model) {
      Joint& joint = model.arm.joints[rows.regressor().dynamics().joints()[c]];
      if (joint.spring_stiffness > 0.0) return false;  // two of them have no common rest that the offset would leave
      joint.spring_stiffness = theta[0];
      joint.spring_rest = middle;
      return true;
    };
  });
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::joint_spring
