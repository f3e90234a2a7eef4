/// \file
/// A motor that gives less torque per ampere where it draws much: + s I^3, I what the model says. Of logs of currents.
#include "diagnose/robots/robot_cause.h"

namespace simgap::robot_causes::torque_saturation {
namespace {

using Eigen::VectorXd;

constexpr char kName[] = "torque-saturation";

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  if (!rows.model().currents) return {};
  return onEveryJoint(rows, kName, [&rows](std::size_t c, RobotHypothesis& h) {
    h.drive = static_cast<int>(c);
    h.sentence = "the motor gives less torque per ampere where it draws much";
    h.separates = "this joint's largest loads in both directions, held still and moving";
    h.parameters = {{{"s", "1_A2", 0.0}}};
    h.torque = [&rows, c](const VectorXd& theta) {
      const Eigen::ArrayXd current = rows.torque().col(c).array() / rows.constant(c);
      return onJoint(rows.joints(), c, theta[0] * rows.constant(c) * current.cube());
    };
  });
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::torque_saturation
