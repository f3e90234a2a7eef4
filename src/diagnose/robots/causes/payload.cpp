/// \file
/// A mass at a point of a body that the model does not have, throughout the log.
#include "point_mass.h"

namespace simgap::robot_causes::payload {
namespace {

constexpr char kName[] = "payload";

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  const RobotRegressor& regressor = rows.regressor();
  return onEveryBody(rows, kName, [&regressor](std::size_t b, RobotHypothesis& h) {
    describePointMass(h);
    h.sentence = "the body carries a mass that the model does not have";
    h.separates = "the same motion with the load taken off, or with a known mass at another place of the body";
    h.change = [&regressor, b](const Eigen::VectorXd& theta) { return pointMass(regressor, b, theta); };
  });
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::payload
