/// \file
/// One number of a joint's drive is not what the model says: its rotor's inertia, its dry friction, its viscous
/// friction. What is left has to be physical: none of them is below 0.
#include "diagnose/robots/robot_cause.h"

namespace simgap::robot_causes::drive_parameters {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr const char* kNames[] = {"rotor-inertia", "coulomb-offset", "viscous-friction"};

RobotHypothesis changed(const RobotRows& rows, const char* cause, std::size_t c, RobotCauseParameter parameter,
                        std::vector<Index> columns) {
  RobotHypothesis h;
  h.cause = cause;
  h.target = rows.jointName(c);
  h.parameters = {std::move(parameter)};
  const Index all = rows.regressor().columns();
  h.change = [all, columns = std::move(columns)](const VectorXd& theta) {
    VectorXd change = VectorXd::Zero(all);
    for (const Index k : columns) change[k] = theta[0];
    return change;
  };
  return h;
}

/// Columns of a joint's friction that grow alike with speed or direction.
std::vector<Index> frictionColumns(const RobotRegressor& regressor, std::size_t c, FrictionBasis basis) {
  std::vector<Index> columns;
  Index at = regressor.frictionColumn(c);
  for (const FrictionTerm& term : regressor.law().terms) {
    if (term.basis == basis) columns.push_back(at);
    ++at;
  }
  return columns;
}

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  std::vector<RobotHypothesis> list;
  const RobotRegressor& regressor = rows.regressor();
  for (std::size_t c = 0; c < rows.joints(); ++c) {
    const bool slides = rows.joint(c).slides();
    RobotHypothesis rotor = changed(rows, kNames[0], c, {{"dJ", slides ? "kg" : "kg_m2"}}, {regressor.rotorColumn(c)});
    rotor.sentence = "the drive's rotor, as it is felt at the joint, is heavier or lighter than the model's";
    rotor.separates = "fast and slow turns of this joint alone, the others held";
    RobotHypothesis dry = changed(rows, kNames[1], c, {{"n_c2", effortUnit(rows.joint(c))}},
                                  frictionColumns(regressor, c, FrictionBasis::kDirection));
    dry.sentence = "dry friction of the joint differs from the model's by the same at every load";
    dry.separates = "slow motion of this joint in both directions";
    dry.parameters[0].lower = -std::max(rows.coulomb(c), 0.0) * 1.05;
    RobotHypothesis viscous = changed(rows, kNames[2], c, {{"k_v", slides ? "Ns_m" : "Nms_rad"}},
                                      frictionColumns(regressor, c, FrictionBasis::kVelocity));
    viscous.sentence = "viscous friction of the joint differs from the model's";
    viscous.separates = "several constant speeds of this joint in both directions";
    viscous.parameters[0].lower = -std::max(rows.viscous(c), 0.0) * 1.05;
    for (RobotHypothesis* h : {&rotor, &dry, &viscous}) list.push_back(std::move(*h));
  }
  return list;
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{[] { return RobotCause::Names(std::begin(kNames), std::end(kNames)); }, hypotheses};

}  // namespace simgap::robot_causes::drive_parameters
