/// \file
/// All that is logged of a joint, motion and effort, is late by dt against the other joints: theirs meet its motion of
/// dt later rows, and its effort belongs to their motion of dt before.
#include <algorithm>
#include <cmath>

#include "diagnose/robots/robot_cause.h"

namespace simgap::robot_causes::clock_offset {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr char kName[] = "clock-offset";

MatrixXd lateBy(const RobotRows& rows, std::size_t late, double dt) {
  MatrixXd torque = rows.rigidChange(
      [&](std::size_t row, RobotMotion& motion, Vector3d&) { rows.motionAfter(late, row, dt, motion); });
  const MatrixXd own = rows.rigidChange([&](std::size_t row, RobotMotion& motion, Vector3d&) {
    for (std::size_t c = 0; c < rows.joints(); ++c) {
      if (c != late) rows.motionAfter(c, row, -dt, motion);
    }
  });
  const auto column = static_cast<Index>(late);
  torque.col(column) = own.col(column);
  return torque;
}

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  if (rows.joints() < 2) return {};
  const double step = rows.drive(0).step;
  return onEveryJoint(rows, kName, [&rows, step](std::size_t c, RobotHypothesis& h) {
    h.sentence = "all that is logged of this joint comes later, or earlier, than what is logged of the others";
    h.separates = "a knock at the base that all joints see";
    h.parameters = {{{"dt", "s", -0.5, 0.5}, step}};
    h.linear = false;
    h.torque = [&rows, c](const VectorXd& theta) { return onAll(lateBy(rows, c, theta[0])); };
    // What the reading of a log puts right by halves of a row is no clock.
    const double shortest = std::max(0.75 * step, rows.shortestDelay(c));
    h.counts = [shortest](const VectorXd& theta) { return std::abs(theta[0]) >= shortest; };
  });
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::clock_offset
