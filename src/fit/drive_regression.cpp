#include "simgap/fit/drive_regression.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/fit/separable.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Kind = EffectParameter::Kind;

constexpr double kInf = std::numeric_limits<double>::infinity();

/// The unit a catalogue entry means on this drive: "Nm" is the load's, "A" the effort's.
std::string unitOn(std::string_view unit, const DriveData& data) {
  std::string text(unit);
  const auto replace = [&](std::string_view from, const std::string& to) {
    if (const auto at = text.find(from); at != std::string::npos) text.replace(at, from.size(), to);
  };
  if (data.load_unit == "N") {
    replace("Nm", "N");
    replace("rad", "m");
  }
  if (data.effort_unit != "A") replace("A", data.effort_unit);
  return text;
}

std::string termUnit(FrictionBasis basis, const DriveData& data) {
  if (basis == FrictionBasis::kLoad) return "1";
  if (basis == FrictionBasis::kDirection) return data.load_unit;
  return data.load_unit == "N" ? "Ns_m" : "Nms_rad";
}

}  // namespace

bool DriveData::has(Channel channel) const {
  switch (channel) {
    case Channel::kJointAngle:
      return rows.joint_angle.size() > 0;
    case Channel::kMotorAngle:
      return rows.motor_angle.size() > 0;
    case Channel::kTemperature:
      return rows.temperature.size() > 0;
  }
  return false;
}

DriveRegression::DriveRegression(const FrictionLaw& law, std::vector<const DriveEffect*> effects, const DriveData& data,
                                 std::optional<double> presliding)
    : law_(&law), effects_(std::move(effects)), data_(&data), presliding_(presliding.has_value()) {
  const auto addLinear = [&](std::string name, std::string unit, double lower, double upper, bool times_gain) {
    add(std::move(name), std::move(unit), lower, upper);
    times_gain_.push_back(times_gain);
  };
  addLinear("k_a", data.load_unit == data.effort_unit ? "1" : data.load_unit + "_" + data.effort_unit, 1e-12, kInf,
            false);
  for (const FrictionTerm& term : law.terms)
    addLinear(std::string(term.name), termUnit(term.basis, data), 0.0, kInf, true);
  for (const FitParameter& p : data.rig_parameters) addLinear(p.name, p.unit, 0.0, kInf, true);
  if (data.offset) addLinear("offset", data.effort_unit, -kInf, kInf, false);
  for (const DriveEffect* effect : effects_) {
    column_begin_.push_back(parameters_.size());
    for (const EffectColumn& column : effect->columns) {
      addLinear(fmt::format("{}.{}", effect->name, column.name), unitOn(column.unit, data), column.lower, column.upper,
                column.torque);
    }
  }
  linear_ = parameters_.size();
  if (law.hasStribeck()) {
    add("v_s", data.velocity_unit, 1e-4 * data.rows.top_speed, 3.0 * data.rows.top_speed);
    add("delta", "1", 0.2, 8.0);
  }
  if (presliding) add("presliding", "rad", 1e-6, *presliding);
  for (const DriveEffect* effect : effects_) {
    p_begin_.push_back(parameters_.size());
    for (const EffectParameter& p : effect->parameters) {
      add(fmt::format("{}.{}", effect->name, p.name), unitOn(p.unit, data), p.lower, p.upper, p.kind != Kind::kSmooth);
    }
  }
  const std::vector<int>& session = data.rows.session;
  const auto n = static_cast<std::size_t>(data.rows.rows());
  session_begin_.resize(n);
  session_end_.resize(n);
  for (std::size_t i = 0; i < n; ++i) {
    session_begin_[i] = i > 0 && session[i] == session[i - 1] ? session_begin_[i - 1] : static_cast<Index>(i);
  }
  for (std::size_t i = n; i-- > 0;) {
    session_end_[i] = i + 1 < n && session[i] == session[i + 1] ? session_end_[i + 1] : static_cast<Index>(i + 1);
  }
}

void DriveRegression::add(std::string name, std::string unit, double lower, double upper, bool fixed) {
  parameters_.push_back({std::move(name), std::move(unit), lower, upper, fixed});
}

DriveRegression::Evaluation DriveRegression::columns(std::span<const double> p) const {
  const DriveRows& rows = data_->rows;
  const Index n = rows.rows();
  DriveTerms terms{rows.load, rows.direction, rows.speed, ArrayXd(), 0.0, 0.0};
  terms.gain = ArrayXd::Ones(n);
  std::size_t at = 0;
  ArrayXd still = ArrayXd::Zero(n);
  if (law_->hasStribeck()) {
    still = (-(p[1] * (rows.speed.abs().max(1e-12).log() - std::log(p[0]))).min(50.0).exp()).exp();
    at = 2;
  }
  if (presliding_) drive_effects::find("presliding-hysteresis").apply(p.subspan(at++, 1), rows, terms);
  const auto own = [&](std::size_t e) { return p.subspan(p_begin_[e] - linear_, effects_[e]->parameters.size()); };
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    if (effects_[e]->apply != nullptr) effects_[e]->apply(own(e), rows, terms);
  }
  Evaluation result{Eigen::MatrixXd(n, static_cast<Index>(linear_)), terms.cubic};
  auto x = result.x.array();
  x.col(0) = terms.load;
  Index j = 1;
  for (const FrictionTerm& term : law_->terms) {
    auto column = x.col(j++);
    if (term.basis == FrictionBasis::kVelocity) {
      column = terms.viscous;
    } else if (term.basis == FrictionBasis::kLoad) {
      column = terms.load.abs() * terms.dry;
    } else {
      column = terms.dry;
    }
    if (term.shape == FrictionShape::kStatic) column *= still;
    if (term.shape == FrictionShape::kSliding) column *= 1.0 - still;
  }
  for (Index k = 0; k < data_->rig.cols(); ++k) x.col(j++) = data_->rig.col(k);
  if (data_->offset) x.col(j++) = 1.0;
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    const auto count = static_cast<Index>(effects_[e]->columns.size());
    if (count == 0) continue;
    effects_[e]->fill(own(e), rows, terms, still, x.middleCols(j, count));
    j += count;
  }
  for (std::size_t c = 0; c < linear_; ++c) {
    if (c == 0 || times_gain_[c]) x.col(static_cast<Index>(c)) /= terms.gain;
  }
  if (terms.delay == 0.0) return result;
  // effort(t) = P(t - delay): between the two rows before that moment, within the session.
  const double shift = terms.delay / rows.step;
  const auto whole = static_cast<Index>(std::floor(shift));
  const double part = shift - static_cast<double>(whole);
  result.keep = data_->keep;
  const Eigen::MatrixXd original = result.x;
  for (Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const Index later = std::clamp(i - whole, session_begin_[k], session_end_[k] - 1);
    const Index earlier = std::clamp(i - whole - 1, session_begin_[k], session_end_[k] - 1);
    result.x.row(i) = (1.0 - part) * original.row(later) + part * original.row(earlier);
    result.keep[k] = data_->keep[static_cast<std::size_t>(later)] && data_->keep[static_cast<std::size_t>(earlier)];
  }
  return result;
}

Eigen::ArrayXd DriveRegression::predict(const Evaluation& e, std::span<const double> theta) const {
  const ArrayXd linear = e.x * Eigen::Map<const Eigen::VectorXd>(theta.data(), static_cast<Index>(linear_));
  return e.cubic == 0.0 ? linear : ArrayXd(linear + e.cubic * linear.cube());
}

Eigen::ArrayXd DriveRegression::predict(std::span<const double> theta) const {
  return predict(columns(theta.subspan(linear_)), theta);
}

Eigen::ArrayXd DriveRegression::friction(std::span<const double> theta) const {
  std::vector<double> without(theta.begin(), theta.end());
  without[0] = 0.0;
  return predict(without);
}

void DriveRegression::evaluate(std::span<const double> theta, Eigen::VectorXd& residual,
                               Eigen::MatrixXd* jacobian) const {
  const Index n = rows();
  const std::span<const double> p = theta.subspan(linear_);
  const Evaluation e = columns(p);
  const ArrayXd predicted = predict(e, theta);
  residual = (predicted - data_->rows.effort).matrix();
  const std::vector<bool>& keep = e.keep.empty() ? data_->keep : e.keep;
  const auto blank = [&](auto&& array) {
    for (Index i = 0; i < n; ++i) {
      if (!keep[static_cast<std::size_t>(i)]) array.row(i).setZero();
    }
  };
  blank(residual);
  if (jacobian == nullptr) return;
  jacobian->resize(n, static_cast<Index>(parameters_.size()));
  const auto linear = static_cast<Index>(linear_);
  if (e.cubic == 0.0) {
    jacobian->leftCols(linear) = e.x;
  } else {
    const Eigen::VectorXd x_c = e.x * Eigen::Map<const Eigen::VectorXd>(theta.data(), linear);
    const ArrayXd slope = 1.0 + 3.0 * e.cubic * x_c.array().square();
    jacobian->leftCols(linear) = (e.x.array().colwise() * slope).matrix();
  }
  std::vector<double> moved(theta.begin(), theta.end());
  for (std::size_t i = linear_; i < parameters_.size(); ++i) {
    auto column = jacobian->col(static_cast<Index>(i));
    const FitParameter& parameter = parameters_[i];
    if (parameter.fixed) {
      column.setZero();
      continue;
    }
    double h = 1e-5 * std::max(std::abs(theta[i]), 1e-2);
    if (theta[i] + h > parameter.upper) h = -h;
    moved[i] = theta[i] + h;
    column = ((predict(columns(std::span<const double>(moved).subspan(linear_)), moved) - predicted) / h).matrix();
    moved[i] = theta[i];
  }
  blank(*jacobian);
}

std::vector<double> DriveRegression::startFrom(const DriveRegression& other, std::span<const double> theta) const {
  std::vector<double> start(parameters_.size(), 0.0);
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    for (std::size_t k = 0; k < effects_[e]->parameters.size(); ++k) {
      start[p_begin_[e] + k] = effects_[e]->parameters[k].start;
    }
  }
  if (presliding_) start[linear_ + (law_->hasStribeck() ? 2 : 0)] = 1e-3;
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const auto found = std::ranges::find(other.parameters_, parameters_[i].name, &FitParameter::name);
    if (found != other.parameters_.end()) start[i] = theta[static_cast<std::size_t>(found - other.parameters_.begin())];
  }
  return start;
}

std::vector<double> DriveRegression::solveCoefficients(std::vector<double> theta, std::span<const Block> blocks) const {
  const Evaluation e = columns(std::span<const double>(theta).subspan(linear_));
  const auto c = static_cast<Index>(linear_);
  Eigen::MatrixXd gram = Eigen::MatrixXd::Zero(c + 1, c + 1);
  Eigen::VectorXd row(c + 1);
  for (const Block& b : blocks) {
    for (std::size_t k = b.begin; k < b.end; ++k) {
      if (!data_->keep[k]) continue;
      const auto i = static_cast<Index>(k);
      row << e.x.row(i).transpose(), data_->rows.effort[i];
      gram.selfadjointView<Eigen::Lower>().rankUpdate(row);
    }
  }
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
  std::vector<LinearTerm> terms;
  for (std::size_t i = 0; i < linear_; ++i) {
    terms.push_back({parameters_[i].name, parameters_[i].lower, parameters_[i].upper, times_gain_[i]});
  }
  const LinearSolution solution = solveBounded(gram, terms);
  std::copy(solution.coefficients.begin(), solution.coefficients.end(), theta.begin());
  return theta;
}

std::vector<double> DriveRegression::thetaOf(std::span<const PhysicalParameter> physical) const {
  const auto value = [&](const std::string& name, double otherwise) {
    const auto found = std::ranges::find(physical, name, &PhysicalParameter::name);
    return found == physical.end() ? otherwise : found->value;
  };
  std::vector<double> theta(parameters_.size());
  theta[0] = 1.0 / value("k_a", 1.0);
  for (std::size_t i = 1; i < linear_; ++i) {
    theta[i] = value(parameters_[i].name, 0.0) * (times_gain_[i] ? theta[0] : 1.0);
  }
  for (std::size_t i = linear_; i < theta.size(); ++i) {
    theta[i] = value(parameters_[i].name, parameters_[i].name == "presliding" ? 1e-6 : 1.0);
  }
  return theta;
}

std::vector<PhysicalParameter> DriveRegression::physical(std::span<const double> theta,
                                                         const Eigen::MatrixXd& covariance) const {
  std::vector<PhysicalParameter> list;
  const double gain = theta[0];
  for (std::size_t i = 0; i < parameters_.size(); ++i) {
    const FitParameter& parameter = parameters_[i];
    const auto k = static_cast<Index>(i);
    PhysicalParameter p{parameter.name, parameter.unit, theta[i], 0.0, atBound(parameter, theta[i])};
    double variance = covariance(k, k);
    if (i == 0) {
      p.value = 1.0 / gain;
      variance /= std::pow(gain, 4);
    } else if (i < linear_ && times_gain_[i]) {
      p.value = theta[i] / gain;
      variance = (variance - 2.0 * p.value * covariance(k, 0) + p.value * p.value * covariance(0, 0)) / (gain * gain);
    }
    p.sd = !parameter.fixed && covariance(k, k) > 0.0 ? std::sqrt(std::max(variance, 0.0)) : std::nan("");
    list.push_back(p);
  }
  return list;
}

std::vector<Extension> DriveRegression::extensions(std::span<const double> theta,
                                                   const Eigen::MatrixXd& covariance) const {
  const std::vector<PhysicalParameter> all = physical(theta, covariance);
  std::vector<Extension> list;
  for (std::size_t e = 0; e < effects_.size(); ++e) {
    Extension& extension = list.emplace_back();
    extension.effect = effects_[e]->name;
    const auto take = [&](std::size_t i, std::string_view name) {
      extension.parameters.push_back({std::string(name), all[i].unit, all[i].value, all[i].sd});
    };
    for (std::size_t k = 0; k < effects_[e]->columns.size(); ++k)
      take(column_begin_[e] + k, effects_[e]->columns[k].name);
    for (std::size_t k = 0; k < effects_[e]->parameters.size(); ++k)
      take(p_begin_[e] + k, effects_[e]->parameters[k].name);
  }
  return list;
}

}  // namespace simgap
