/// \file
/// A body's inertia is not what the model says, its mass and centre are: dI, symmetric, six numbers of which only those
/// that any joint feels are asked for.
#include "diagnose/robots/robot_cause.h"

namespace simgap::robot_causes::link_inertia {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr char kName[] = "link-inertia";
constexpr Index kFirst = 4;  // of a body's ten numbers

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  const RobotRegressor& regressor = rows.regressor();
  return onEveryBody(rows, kName, [&regressor](std::size_t b, RobotHypothesis& h) {
    h.sentence = "the body's inertia differs from the model's, its mass and centre do not";
    h.separates = "fast turns of this joint and of those before it, the arm once stretched and once folded";
    for (Index k = kFirst; k < kBodyParameters; ++k) {
      h.parameters.push_back({{std::string("d") + bodyParameterNames()[k], "kg_m2"}});
    }
    h.change = [&regressor, b](const VectorXd& theta) {
      VectorXd change = VectorXd::Zero(regressor.columns());
      change.segment(regressor.bodyColumn(b) + kFirst, kBodyParameters - kFirst) = theta;
      return change;
    };
  });
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names{kName}; }, hypotheses};

}  // namespace simgap::robot_causes::link_inertia
