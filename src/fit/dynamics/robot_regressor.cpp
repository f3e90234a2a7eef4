#include "simgap/fit/dynamics/robot_regressor.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/joint_kind.h"
#include "simgap/model/friction/friction_evaluation.h"

namespace simgap {
namespace {

using Eigen::Index;

const char* termUnit(FrictionBasis basis, bool slides) {
  if (basis == FrictionBasis::kLoad) return "1";
  if (basis == FrictionBasis::kVelocity) return slides ? "Ns_m" : "Nms_rad";
  return slides ? "N" : "Nm";
}

const char* bodyUnit(Index k) { return k == 0 ? "kg" : k < 4 ? "kg_m" : "kg_m2"; }

}  // namespace

RobotRegressor::RobotRegressor(const ArmModel& model, const FrictionLaw& law)
    : dynamics_(model), law_(&law), gravity_(model.gravity), load_(dynamics_.parametersOf(model)) {
  for (const int body : dynamics_.bodies()) massless_.push_back(!(massProperties(model.bodies[body]).mass > 0.0));
  const auto add = [&](std::string name, const char* unit) {
    names_.push_back(std::move(name));
    units_.emplace_back(unit);
  };
  for (const int j : dynamics_.joints()) {
    const Joint& joint = model.joints[j];
    add(joint.name + ".offset", joint.slides() ? "N" : "Nm");
    for (const FrictionTerm& term : law.terms) {
      add(fmt::format("{}.{}", joint.name, term.name), termUnit(term.basis, joint.slides()));
    }
  }
  for (const int body : dynamics_.bodies()) {
    for (Index k = 0; k < kBodyParameters; ++k) {
      add(fmt::format("{}.{}", model.bodies[body].name, bodyParameterNames()[k]), bodyUnit(k));
    }
  }
  for (const int j : dynamics_.joints()) {
    add(model.joints[j].name + ".rotor", model.joints[j].slides() ? "kg" : "kg_m2");
  }
}

Index RobotRegressor::columns() const { return std::ssize(names_); }
Index RobotRegressor::offsetColumn(std::size_t c) const { return static_cast<Index>(c * (1 + law_->terms.size())); }
Index RobotRegressor::bodyColumn(std::size_t b) const {
  return offsetColumn(coordinates()) + kBodyParameters * static_cast<Index>(b);
}
Index RobotRegressor::rotorColumn(std::size_t c) const { return bodyColumn(bodies()) + static_cast<Index>(c); }

void RobotRegressor::setLoad(const Eigen::VectorXd& parameters) {
  load_ = parameters.segment(bodyColumn(0), dynamics_.parameters());
}

RobotRegressor::Workspace RobotRegressor::workspace() const {
  return {dynamics_.workspace(), RegressorMatrix(coordinates(), dynamics_.parameters()),
          Eigen::VectorXd::Zero(static_cast<Index>(coordinates()))};
}

void RobotRegressor::rows(const RobotMotion& motion, std::span<const StribeckCurve> curves, Workspace& work,
                          Eigen::Ref<RegressorMatrix> y) const {
  dynamics_.regressor(motion.position, motion.velocity, motion.acceleration, gravity_, work.motion, work.bodies);
  y.setZero();
  y.middleCols(bodyColumn(0), dynamics_.parameters()) = work.bodies;
  for (std::size_t b = 0; b < bodies(); ++b) {
    if (massless_[b]) y.middleCols(bodyColumn(b), kBodyParameters).setZero();
  }
  if (law_->needsLoad()) work.load.noalias() = work.bodies * load_;
  for (std::size_t c = 0; c < coordinates(); ++c) {
    const Index row = c;
    const double load =
        law_->needsLoad() ? std::abs(work.load[row] + dynamics_.springTorque(c, motion.position[c])) : 0.0;
    const double velocity = motion.velocity[c], direction = motion.direction[c];
    y(row, offsetColumn(c)) = 1.0;
    y(row, rotorColumn(c)) = motion.acceleration[c];
    const double factor =
        law_->hasStribeck() ? std::exp(-std::pow(std::abs(velocity / curves[c].v_s), curves[c].delta)) : 0.0;
    Index at = frictionColumn(c);
    for (const FrictionTerm& term : law_->terms) {
      visitBasis(term.basis, load, direction, velocity, [&](double column) {
        visitShape(term.shape, column, factor, [&](double shaped) { y(row, at++) = shaped; });
      });
    }
  }
}

}  // namespace simgap
