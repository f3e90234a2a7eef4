/// \file
/// The position of one joint is logged dt later than all efforts and the other positions: its encoder is filtered, or
/// comes by a slower bus. Every torque meets its motion of dt later rows, that of its own friction and rotor, too.
#include <algorithm>
#include <cmath>

#include "diagnose/robots/robot_cause.h"

namespace simgap::robot_causes::position_delay {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr char kName[] = "position-delay";

MatrixXd lateBy(const RobotRows& rows, std::size_t late, double dt) {
  MatrixXd torque = rows.rigidChange(
      [&](std::size_t row, RobotMotion& motion, Vector3d&) { rows.motionAfter(late, row, dt, motion); });
  const auto column = static_cast<Index>(late);
  const ArrayXd drive = (rows.torque() - rows.rigid()).col(column).array();
  torque.col(column).array() += rows.shifted(drive, dt) - drive;
  return torque;
}

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  const double step = rows.drive(0).step;
  return onEveryJoint(rows, kName, [&rows, step](std::size_t c, RobotHypothesis& h) {
    h.sentence = "the position of this joint is logged later than the efforts and than the other positions";
    h.separates = "fast reversals of this joint while a neighbour holds still, and a knock that all channels see";
    // An early position would be the lateness of all else: its effort's (channel-delay) or its own and another's.
    h.parameters = {{{"dt", "s", 0.0, 0.5}, step}};
    h.linear = false;
    h.torque = [&rows, c](const VectorXd& theta) { return onAll(lateBy(rows, c, theta[0])); };
    h.later = [](const VectorXd& theta) { return theta[0]; };
    // Not three quarters of a row, as an effort's: motion is read from the position itself, so that halves of a row are
    // no matter of reading, and what has no name here passes for less viscous friction.
    const double shortest = std::max(0.1 * step, rows.shortestDelay(c));
    h.counts = [shortest](const VectorXd& theta) { return theta[0] >= shortest; };
  });
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::position_delay
