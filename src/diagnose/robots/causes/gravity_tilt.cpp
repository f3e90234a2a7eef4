/// \file
/// The base stands otherwise than the model says: gravity is turned about the two axes of the base that lie across it.
#include "diagnose/robots/robot_cause.h"
#include "simgap/core/rotation.h"

namespace simgap::robot_causes::gravity_tilt {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr char kName[] = "gravity-tilt";
constexpr double kSteepest = 0.5;  // [rad]: nobody overlooks more

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  const Vector3d gravity = rows.model().arm.gravity;
  if (gravity.norm() == 0.0) return {};
  Eigen::Index along = 0;
  gravity.cwiseAbs().maxCoeff(&along);
  const Eigen::Index first = along == 0 ? 1 : 0, second = along == 2 ? 1 : 2;
  const auto turnOf = [first, second](const VectorXd& theta) {
    Vector3d turn = Vector3d::Zero();
    turn[first] = theta[0];
    turn[second] = theta[1];
    return turn;
  };
  RobotHypothesis h;
  h.cause = kName;
  h.sentence = "the base is tilted against gravity";
  h.separates = "the base with a level beside it, or the same slow motion after the base was turned about the vertical";
  for (const Eigen::Index axis : {first, second}) {
    h.parameters.push_back({{std::string("turn_") + "xyz"[axis], "rad", -kSteepest, kSteepest}, 1e-2});
  }
  h.linear = false;
  h.torque = [&rows, turnOf](const VectorXd& theta) {
    const Eigen::Matrix3d turned = expSo3(turnOf(theta)).toRotationMatrix();
    return onAll(rows.rigidChange([&](std::size_t, RobotMotion&, Vector3d& g) { g = turned * g; }));
  };
  h.hold = [turnOf](const VectorXd& theta, RobotModel& model) {
    model.arm.gravity = expSo3(turnOf(theta)) * model.arm.gravity;
    return true;
  };
  return {h};
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::gravity_tilt
