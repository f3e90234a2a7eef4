/// \file
/// A joint's effort is worth more, or less, torque than is said: k (1 + s). The effort is tau / (1 + s) of what is
/// asked.
#include "diagnose/robots/robot_cause.h"

namespace simgap::robot_causes::torque_constant {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr char kName[] = "torque-constant";

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  return onEveryJoint(rows, kName, [&rows](std::size_t c, RobotHypothesis& h) {
    h.sentence = "the joint's effort is worth another torque than was said";
    h.separates = "a known weight held by this joint at several positions";
    h.parameters = {{{"change", "1", -0.8, 4.0}, 1e-2}};
    h.linear = false;
    h.torque = [&rows, c](const VectorXd& theta) {
      const double factor = 1.0 / (1.0 + std::max(theta[0], -0.9)) - 1.0;
      return onJoint(rows.joints(), c, factor * rows.torque().col(c).array());
    };
    h.hold = [c](const VectorXd& theta, RobotModel& model) {
      if (model.currents) model.torque_constants[c] *= 1.0 + theta[0];
      return model.currents;
    };
  });
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::torque_constant
