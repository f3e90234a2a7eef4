/// \file
/// Causes of single drives (src/model/effects/drive) at every joint of a robot: a joint is a drive whose load is what
/// the bodies ask of it. Their columns, or what they change of friction and of time, are the torque that they add.
#include <fmt/format.h>

#include <algorithm>
#include <numbers>

#include "diagnose/robots/robot_cause.h"
#include "simgap/core/decompositions.h"
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::robot_causes::drive_effects {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::VectorXd;
using Kind = EffectParameter::Kind;

constexpr std::size_t kMostStarts = 4;

ActuatorTerms termsOf(const ActuatorRows& rows) {
  ActuatorTerms terms;
  terms.load = rows.load;
  terms.dry = rows.direction;
  terms.viscous = rows.speed;
  return terms;
}

/// What a changed drive exerts more.
ArrayXd changedTorque(const RobotRows& rows, std::size_t c, const ActuatorEffect& effect, std::span<const double> p) {
  const ActuatorRows& drive = rows.drive(c);
  ActuatorTerms terms = termsOf(drive);
  effect.apply(p, drive, terms);
  ArrayXd more = rows.coulomb(c) * (terms.dry - drive.direction) + rows.viscous(c) * (terms.viscous - drive.speed);
  if (terms.delay == 0.0) return more;
  const ArrayXd torque = rows.torque().col(c).array();
  return more + rows.shifted(torque, -terms.delay) - torque;
}

std::string unitAt(const RobotRows& rows, std::size_t c, const EffectColumn& column) {
  if (!column.torque) return rows.log().joints[c].effort_unit;
  if (column.unit == "Nm") return effortUnit(rows.joint(c));
  if (!rows.joint(c).slides()) return std::string(column.unit);
  return column.unit == "Nms_rad" ? "Ns_m" : column.unit == "1_Nm" ? "1_N" : std::string(column.unit);
}

/// "; T_mean = 31.5 degC": what is no number of the fit.
std::string fixedAt(const ActuatorEffect& effect, const std::vector<double>& p) {
  std::string text;
  for (std::size_t k = 0; k < p.size(); ++k) {
    const EffectParameter& parameter = effect.parameters[k];
    if (parameter.kind == Kind::kSmooth || p[k] == parameter.neutral) continue;
    text += fmt::format("; {} = {:.3g}{}", parameter.name, p[k],
                        parameter.unit == "1" ? "" : fmt::format(" {}", parameter.unit));
  }
  return text;
}

RobotHypothesis named(const RobotRows& rows, std::size_t c, const ActuatorEffect& effect) {
  RobotHypothesis h;
  h.cause = effect.name;
  h.form = effect.form;
  h.target = rows.jointName(c);
  h.drive = static_cast<int>(c);
  h.sentence = effect.cause;
  h.separates = effect.separates;
  return h;
}

/// Columns whose shape is fixed where a search begins.
RobotHypothesis byColumns(const RobotRows& rows, std::size_t c, const ActuatorEffect& effect,
                          const std::vector<double>& p) {
  RobotHypothesis h = named(rows, c, effect);
  for (const EffectColumn& column : effect.columns) {
    h.parameters.push_back({{std::string(column.name), unitAt(rows, c, column), column.lower, column.upper}});
  }
  h.searched = effect.places;
  h.torque = [&rows, c, &effect, p](const VectorXd& theta) {
    const ActuatorRows& drive = rows.drive(c);
    Eigen::ArrayXXd x(drive.rows(), std::ssize(effect.columns));
    effect.fill(p, drive, termsOf(drive), ArrayXd::Zero(drive.rows()), x);
    ArrayXd torque = ArrayXd::Zero(drive.rows());
    for (Index k = 0; k < x.cols(); ++k) {
      const bool is_torque = effect.columns[k].torque;
      torque += theta[k] * (is_torque ? 1.0 : rows.constant(c)) * x.col(k);
    }
    return onJoint(rows.joints(), c, torque);
  };
  if (effect.is_offset) {
    const Index column = rows.regressor().offsetColumn(c);
    const double constant = rows.constant(c);
    h.hold = [column, constant](const VectorXd& theta, RobotModel& model) {
      model.parameters[column] += constant * theta[0];
      return true;
    };
  }
  if (effect.counts != nullptr) {
    h.counts = [&rows, c, &effect, p](const VectorXd&) { return effect.counts(p, rows.drive(c)); };
  }
  return h;
}

/// Whether columns have one shape that is looked for over the joint's angle: periods of a ripple.
bool repeats(const ActuatorEffect& effect) {
  return effect.places > 1.0 && effect.parameters.size() == 1 && effect.parameters[0].kind == Kind::kShape &&
         std::ranges::find(effect.needs, OptionalChannel::kJointAngle) != effect.needs.end();
}

/// Columns whose period is fitted besides, from where a search over the angle has found it. \param r  periods per 2 pi
RobotHypothesis byPeriod(const RobotRows& rows, std::size_t c, const ActuatorEffect& effect, double r) {
  RobotHypothesis h = byColumns(rows, c, effect, {r});
  const ActuatorRows& drive = rows.drive(c);
  const EffectParameter& parameter = effect.parameters[0];
  // Half a period over the whole range: beyond that lies another peak.
  const double half = std::numbers::pi / (drive.joint_angle.maxCoeff() - drive.joint_angle.minCoeff());
  const Index columns = std::ssize(effect.columns);
  h.parameters.push_back({{std::string(parameter.name), rows.joint(c).slides() ? "1_m" : std::string(parameter.unit),
                           std::max(parameter.lower - r, -half), std::min(parameter.upper - r, half)},
                          0.02 * half,
                          r});
  const auto fixed = [&rows, c, &effect, r, columns](const VectorXd& theta) {
    return byColumns(rows, c, effect, {r + theta[columns]});
  };
  h.linear = false;
  h.torque = [fixed, columns](const VectorXd& theta) { return fixed(theta).torque(theta.head(columns)); };
  if (effect.counts != nullptr) {
    h.counts = [fixed, columns](const VectorXd& theta) { return fixed(theta).counts(theta.head(columns)); };
  }
  // Where it is nothing its period has no slope: it starts with the size that the residual alone says.
  const ArrayXd residual = rows.residual(c), counted = (residual != 0.0).cast<double>();
  Eigen::MatrixXd shapes(drive.rows(), columns);
  for (Index k = 0; k < columns; ++k) {
    shapes.col(k) = (counted * h.torque(VectorXd::Unit(columns + 1, k))[c]).matrix();
  }
  h.start = VectorXd::Zero(columns + 1);
  h.start.head(columns) = solveLeastSquares(shapes.transpose() * shapes, shapes.transpose() * residual.matrix());
  return h;
}

/// A change of friction or of time by the effect's own numbers; others stay where a search begins.
RobotHypothesis byChange(const RobotRows& rows, std::size_t c, const ActuatorEffect& effect, std::vector<double> p) {
  RobotHypothesis h = named(rows, c, effect);
  std::vector<std::size_t> free;
  for (std::size_t k = 0; k < effect.parameters.size(); ++k) {
    const EffectParameter& parameter = effect.parameters[k];
    if (parameter.kind != Kind::kSmooth) continue;
    const double step = parameter.unit == "s" ? rows.drive(c).step : 0.02;
    h.parameters.push_back({{std::string(parameter.name), std::string(parameter.unit),
                             parameter.lower - parameter.neutral, parameter.upper - parameter.neutral},
                            step,
                            parameter.neutral});
    p[k] = parameter.neutral;
    free.push_back(k);
  }
  const auto valuesAt = [&effect, p, free](const VectorXd& theta) {
    std::vector<double> values = p;
    for (std::size_t k = 0; k < free.size(); ++k) {
      const EffectParameter& parameter = effect.parameters[free[k]];
      values[free[k]] = std::clamp(parameter.neutral + theta[k], parameter.lower, parameter.upper);
    }
    return values;
  };
  h.sentence += fixedAt(effect, p);
  h.linear = false;
  h.torque = [&rows, c, &effect, valuesAt](const VectorXd& theta) {
    return onJoint(rows.joints(), c, changedTorque(rows, c, effect, valuesAt(theta)));
  };
  if (h.isDelay()) h.later = [](const VectorXd& theta) { return -theta[0]; };
  if (effect.counts != nullptr) {
    const double shortest = h.isDelay() ? rows.shortestDelay(c) : 0.0;
    h.counts = [&rows, c, &effect, valuesAt, shortest](const VectorXd& theta) {
      return std::abs(theta[0]) >= shortest && effect.counts(valuesAt(theta), rows.drive(c));
    };
  }
  return h;
}

void addOf(const RobotRows& rows, std::size_t c, const ActuatorEffect& effect, bool other_form,
           std::vector<RobotHypothesis>& list) {
  std::vector<double> start;
  for (const EffectParameter& parameter : effect.parameters) start.push_back(parameter.start);
  std::vector<std::vector<double>> starts = {start};
  if (effect.starts != nullptr) starts = effect.starts(rows.drive(c), rows.residual(c));
  if (effect.columns.empty()) {
    // A change takes many columns: of shapes that are not known the middle one stands for all, and for other forms.
    if (!starts.empty() && (starts.size() == 1 || !other_form)) {
      list.push_back(byChange(rows, c, effect, starts[starts.size() / 2]));
    }
    return;
  }
  for (std::size_t s = 0; s < std::min(starts.size(), kMostStarts); ++s) {
    if (repeats(effect)) {
      list.push_back(byPeriod(rows, c, effect, starts[s][0]));
    } else {
      list.push_back(byColumns(rows, c, effect, starts[s]));
      list.back().sentence += fixedAt(effect, starts[s]);
    }
  }
}

std::vector<RobotHypothesis> hypotheses(const RobotRows& rows) {
  std::vector<RobotHypothesis> list;
  for (std::size_t c = 0; c < rows.joints(); ++c) {
    for (const ActuatorEffect* effect : actuator_effects::all()) {
      if (!effect->on_robot) continue;
      if (effect->contained_in != nullptr && effect->contained_in(rows.regressor().law())) continue;
      addOf(rows, c, *effect, /*other_form=*/false, list);
      for (const ActuatorEffect* form : effect->other_forms) addOf(rows, c, *form, /*other_form=*/true, list);
    }
  }
  return list;
}

/// Dry and viscous friction as such are parameters.
RobotCause::Names names() {
  RobotCause::Names list;
  for (const ActuatorEffect* effect : actuator_effects::all()) {
    if (effect->on_robot) list.push_back(effect->name);
  }
  return list;
}

}  // namespace

extern const RobotCause entry;
const RobotCause entry{names, hypotheses};

}  // namespace simgap::robot_causes::drive_effects
