#include "friction_model.h"

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/fit/actuators/parameter_choices.h"
#include "simgap/model/friction/friction_evaluation.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::ArrayXXd;
using Eigen::Index;

}  // namespace

FrictionModel::FrictionModel(const FrictionLaw& law, const FrictionData& data, const FrictionFitOptions& options)
    : law_(&law),
      data_(&data),
      predict_load_(options.predict_load),
      offset_(options.offset),
      terms_(law.terms.size()),
      stribeck_(law.hasStribeck()),
      rig_(data.rig_names.size()),
      rig_columns_(static_cast<std::size_t>(data.load_per.cols())) {
  if (predict_load_ && rig_ > 0) {
    throw ConfigError("found constants of the rig to be fitted and the load to be predicted, expected one of them");
  }
  addParameter(options, {"k_a", gainUnit(data.load_unit, data.effort_unit), 1e-12, kInfinity});
  for (const ParameterSpec& p : termParameters(law, data.load_unit)) addParameter(options, p);
  for (std::size_t k = 0; k < rig_; ++k) {
    const bool angle = data.fits_angle && k == data.angleIndex();
    addParameter(options, {data.rig_names[k], data.rig_units[k], angle ? -kInfinity : 0.0, kInfinity});
  }
  if (offset_)
    addParameter(options, {"offset", predict_load_ ? data.load_unit : data.effort_unit, -kInfinity, kInfinity});
  linear_ = parameters_.size();
  const double top = std::exp(data.log_speed.maxCoeff());
  for (const ParameterSpec& p : stribeckParameters(law, top, data.velocity_unit)) addParameter(options, p);
}

void FrictionModel::addParameter(const FrictionFitOptions& options, ParameterSpec parameter) {
  constrain({options.fixed, options.bounds}, {&parameter, 1});
  const double value = parameter.fixed ? options.fixed.at(parameter.name) : 0.0;
  if (parameter.fixed) parameter.lower = parameter.upper = value;
  parameters_.push_back(parameter);
  fixed_.push_back(value);
}

std::size_t FrictionModel::freeCount() const {
  return static_cast<std::size_t>(std::ranges::count(parameters_, false, &ParameterSpec::fixed));
}

bool FrictionModel::loadScaleKnown() const {
  if (parameters_[0].fixed || rig_ == 0 || (data_->load != 0.0).any()) return true;
  if (data_->fits_angle) return data_->angleIndex() == 0 || parameters_[1 + terms_].fixed;
  for (std::size_t k = 0; k < rig_; ++k) {
    if (!parameters_[1 + terms_ + k].fixed) return false;
  }
  return true;
}

std::vector<FrictionShape> FrictionModel::shapes() const {
  std::vector<FrictionShape> shapes(linear_ - rig_ + rig_columns_ + 1, FrictionShape::kAlways);
  for (std::size_t j = 0; j < terms_; ++j) shapes[1 + j] = law_->terms[j].shape;
  return shapes;
}

std::vector<LinearTerm> FrictionModel::linearTerms() const {
  std::vector<LinearTerm> terms;
  for (std::size_t i = 0; i < linear_; ++i) {
    const ParameterSpec& p = parameters_[i];
    if (data_->fits_angle && i == 1 + terms_) {
      terms.push_back({"cosine", -kInfinity, kInfinity, true});
      terms.push_back({"sine", -kInfinity, kInfinity, true});
      i += data_->angleIndex();
      continue;
    }
    LinearTerm term{p.name, p.lower, p.upper, false};
    if (i == 0 && !predict_load_) {
      term.lower = std::isfinite(p.upper) ? 1.0 / p.upper : 0.0;
      term.upper = p.lower > 0.0 ? 1.0 / p.lower : kInfinity;
    } else if (i > 0 && i <= terms_) {
      term.times_gain = !predict_load_ || law_->terms[i - 1].basis == FrictionBasis::kLoad;
    } else if (i > terms_ && i <= terms_ + rig_) {
      term.times_gain = true;
    }
    terms.push_back(term);
  }
  return terms;
}

std::vector<NonlinearTerm> FrictionModel::nonlinearTerms() const {
  if (!stribeck_) return {};
  const ParameterSpec& v_s = parameters_[linear_];
  const ParameterSpec& delta = parameters_[linear_ + 1];
  // E falls from 1 to 0 within some 2 / delta of log speed: a steep one makes a narrow valley at every gap between
  // rows.
  const auto step = [](std::span<const double> p) { return 0.4 / p[1]; };
  return {{"v_s", v_s.lower, v_s.upper, true, 48, step}, {"delta", delta.lower, delta.upper, true, 20}};
}

Eigen::VectorXd FrictionModel::initialRig() const {
  std::vector<double> rig;
  for (std::size_t k = 0; k < rig_; ++k) {
    const std::size_t i = 1 + terms_ + k;
    rig.push_back(parameters_[i].fixed ? fixed_[i] : std::clamp(1.0, parameters_[i].lower, parameters_[i].upper));
  }
  return data_->rigCoefficients(rig);
}

Eigen::VectorXd FrictionModel::rigOf(std::span<const double> theta) const {
  return data_->rigCoefficients(theta.subspan(1 + terms_, rig_));
}

Eigen::ArrayXXd FrictionModel::columns(const Eigen::VectorXd& rig, const Block& rows) const {
  const auto begin = static_cast<Index>(rows.begin), n = static_cast<Index>(rows.size());
  const auto terms = static_cast<Index>(terms_), all = static_cast<Index>(linear_ - rig_ + rig_columns_) + 1;
  ArrayXXd x(n, all);
  const auto effort = data_->effort.segment(begin, n);
  ArrayXd load = data_->load.segment(begin, n);
  x.col(0) = predict_load_ ? ArrayXd(effort) : load;
  x.col(all - 1) = predict_load_ ? load : ArrayXd(effort);
  for (Index k = 0; k < rig.size(); ++k) {
    const auto per = data_->load_per.col(k).segment(begin, n);
    x.col(1 + terms + k) = per;
    load += rig[k] * per;
  }
  const ArrayXd size = predict_load_ ? ArrayXd(effort.abs()) : ArrayXd(load.abs());
  const double sign = predict_load_ ? -1.0 : 1.0;
  for (Index j = 0; j < terms; ++j) x.col(1 + j) = sign * basis(law_->terms[j], rows, size);
  if (offset_) x.col(all - 2) = 1.0;
  return x;
}

Eigen::ArrayXd FrictionModel::basis(const FrictionTerm& term, const Block& rows, const ArrayXd& load) const {
  const auto begin = static_cast<Index>(rows.begin), n = static_cast<Index>(rows.size());
  ArrayXd column;
  visitBasis(term.basis, load, data_->direction.segment(begin, n), data_->velocity.segment(begin, n),
             [&](const auto& expression) { column = expression; });
  return column;
}

Eigen::VectorXd FrictionModel::gainFromWeight(Eigen::VectorXd coefficients) const {
  constexpr double kAlike = 0.999;  // correlation: a fitted inertia beside a known one
  if (!data_->fits_angle || data_->angleIndex() > 0 || parameters_[0].fixed) return coefficients;
  const auto weight = static_cast<Index>(1 + terms_);
  const double gain = coefficients.segment<2>(weight).norm(), further = coefficients[0] - gain;
  if (!(gain > 0.0)) return coefficients;
  coefficients[0] = gain;
  for (Index k = 2; k < data_->load_per.cols(); ++k) {
    const auto per = data_->load_per.col(k);
    const double product = (data_->load * per).sum(), squares = per.square().sum();
    if (std::abs(product) < kAlike * std::sqrt(data_->load.square().sum() * squares)) continue;
    if (squares > 0.0) coefficients[weight + k] += further * product / squares;
  }
  return coefficients;
}

std::vector<double> FrictionModel::thetaOf(const SeparableMinimum& minimum) const {
  std::vector<double> theta(parameters_.size());
  const std::vector<LinearTerm> terms = linearTerms();
  Eigen::VectorXd physical = gainFromWeight(minimum.linear.coefficients);
  const double gain = std::max(physical[0], 1e-300);
  for (std::size_t i = 0; i < terms.size(); ++i) {
    if (terms[i].times_gain) physical[i] /= gain;
  }
  const auto law = static_cast<Index>(1 + terms_);
  const std::vector<double> rig = data_->rigConstants(physical.segment(law, rig_columns_));
  theta[0] = predict_load_ ? gain : 1.0 / gain;
  std::copy(physical.begin() + 1, physical.begin() + law, theta.begin() + 1);
  std::ranges::copy(rig, theta.begin() + law);
  if (offset_) theta[linear_ - 1] = physical[physical.size() - 1];
  std::ranges::copy(minimum.p, theta.begin() + static_cast<std::ptrdiff_t>(linear_));
  for (std::size_t i = 0; i < theta.size(); ++i) {
    theta[i] = parameters_[i].fixed ? fixed_[i] : std::clamp(theta[i], parameters_[i].lower, parameters_[i].upper);
  }
  return theta;
}

LeastSquaresProblem FrictionModel::problem() const {
  LeastSquaresProblem problem;
  problem.parameters = parameters_;
  problem.chunks = evenChunks(data_->rows());
  problem.evaluate = [model = *this](std::span<const double> theta, const Block& rows,
                                     Eigen::Ref<Eigen::VectorXd> residual, Eigen::Ref<Eigen::MatrixXd>* jacobian) {
    model.evaluate(theta, rows, residual, jacobian);
  };
  return problem;
}

void FrictionModel::evaluate(std::span<const double> theta, const Block& rows, Eigen::Ref<Eigen::VectorXd> residual,
                             Eigen::Ref<Eigen::MatrixXd>* jacobian) const {
  const auto begin = static_cast<Index>(rows.begin), n = static_cast<Index>(rows.size());
  const auto terms = static_cast<Index>(terms_), rig = static_cast<Index>(rig_);
  const Eigen::VectorXd coefficients = rigOf(theta);
  const double k_a = theta[0];
  const Eigen::Map<const Eigen::VectorXd> law(theta.data() + 1, terms);
  const double offset = offset_ ? theta[linear_ - 1] : 0.0;
  const ArrayXd effort = data_->effort.segment(begin, n);
  ArrayXd load = data_->load.segment(begin, n);
  for (Index k = 0; k < coefficients.size(); ++k) load += coefficients[k] * data_->load_per.col(k).segment(begin, n);
  const ArrayXd driving = predict_load_ ? ArrayXd(k_a * effort) : load;
  const ArrayXd size = driving.abs();
  StribeckFactor stribeck;  // E
  if (stribeck_) stribeck = stribeckFactor(data_->log_speed.segment(begin, n), theta[linear_], theta[linear_ + 1]);
  ArrayXXd z(n, terms);
  ArrayXd per_load = ArrayXd::Zero(n);    // d friction / d |load|
  ArrayXd per_factor = ArrayXd::Zero(n);  // d friction / d E
  for (Index j = 0; j < terms; ++j) {
    const FrictionTerm& term = law_->terms[j];
    const ArrayXd column = basis(term, rows, size);
    if (term.shape == FrictionShape::kStatic) per_factor += law[j] * column;
    if (term.shape == FrictionShape::kSliding) per_factor -= law[j] * column;
    visitShape(term.shape, column, stribeck.value, [&](const auto& shaped) { z.col(j) = shaped; });
    // Where there is no load its derivative does not matter: it is multiplied by the load's sign, 0.
    if (term.basis == FrictionBasis::kLoad) per_load += law[j] * z.col(j) / size.max(1e-300);
  }
  const ArrayXd friction = (z.matrix() * law).array();
  const ArrayXd predicted =
      predict_load_ ? ArrayXd(driving - friction + offset) : ArrayXd((load + friction) / k_a + offset);
  residual = (predicted - (predict_load_ ? data_->load.segment(begin, n) : data_->effort.segment(begin, n))).matrix();
  if (jacobian == nullptr) return;

  Eigen::Ref<Eigen::MatrixXd>& j = *jacobian;
  const double scale = predict_load_ ? -1.0 : 1.0 / k_a;  // of a friction torque in what is predicted
  const ArrayXd sign = driving.sign();
  j.col(0) =
      (predict_load_ ? ArrayXd(effort - per_load * sign * effort) : ArrayXd(-(predicted - offset) / k_a)).matrix();
  j.middleCols(1, terms) = scale * z.matrix();
  if (rig > 0) {
    const Eigen::MatrixXd derivatives = data_->rigDerivatives(theta.subspan(1 + terms_, rig_));
    j.middleCols(1 + terms, rig) = (scale * (1.0 + per_load * sign)).matrix().asDiagonal() *
                                   (data_->load_per.middleRows(begin, n).matrix() * derivatives);
  }
  if (offset_) j.col(static_cast<Index>(linear_) - 1).setOnes();
  if (!stribeck_) return;
  const double v_s = theta[linear_], delta = theta[linear_ + 1];
  const ArrayXd slope = scale * per_factor * stribeck.value * stribeck.exponent;  // times -d log(exponent)
  j.col(linear_) = (slope * (delta / v_s)).matrix();
  j.col(static_cast<Index>(linear_) + 1) = (-slope * (data_->log_speed.segment(begin, n) - std::log(v_s))).matrix();
}

}  // namespace simgap
