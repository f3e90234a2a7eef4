// Residuals of an actuator's equation and their derivatives: exact by what enters linearly and by the Stribeck factor,
// differences by the rest, of which only what a parameter moves is worked out anew.
#include <algorithm>
#include <cmath>

#include "simgap/fit/actuators/actuator_regression.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

}  // namespace

ActuatorRegression::Terms ActuatorRegression::lawTermsBeside(const Terms& near, std::span<const double> p,
                                                             std::size_t moved, double by) const {
  if (!base_.hasStribeck() || moved >= 2) return lawTerms(p, &near.stribeck);
  // E = exp(-x), x = |w / v_s|^delta:  dE/dv_s = E x delta / v_s,  dE/ddelta = -E x ln |w / v_s|.
  Terms t = near;
  const ArrayXd e_x = -near.stribeck * near.stribeck.max(1e-300).log();
  if (moved == 0) {
    t.stribeck += by * p[1] / p[0] * e_x;
  } else {
    t.stribeck -= by * e_x * (log_speed_ - std::log(p[0]));
  }
  return t;
}

ArrayXd ActuatorRegression::predictBeside(const Evaluation& e, const Terms& law, std::span<const double> theta,
                                          std::size_t moved, double by) const {
  const std::span<const double> p = theta.subspan(linear_);
  const bool of_law = moved >= linear_ && (effects_.empty() || moved < p_begin_.front());
  if (implicit_) {
    double delay = 0.0;
    return predict(of_law ? lawTermsBeside(law, p, moved - linear_, by) : law, theta, delay);
  }
  const bool in_stribeck_factor = of_law && base_.hasStribeck() && moved - linear_ < 2;
  const std::size_t owner = of_law ? effects_.size() : effectOf(moved);
  const bool in_terms = !of_law && effects_[owner]->apply != nullptr;
  // What an effect does to the terms does not depend on the Stribeck factor, nor on what only adds columns.
  Terms changed;
  if (in_stribeck_factor) {
    changed = lawTermsBeside(e.terms, p, moved - linear_, by);
  } else if (of_law) {
    changed = withEffects(lawTermsBeside(law, p, moved - linear_, by), p, data_->rows.effort);
  } else if (in_terms) {
    changed = {e.before[owner], e.terms.stribeck, e.terms.weight};
    applyFrom(owner, p, changed.shared);
  }
  const Terms& t = of_law || in_terms ? changed : e.terms;
  Fills same(effects_.size());
  for (std::size_t k = 0; k < effects_.size(); ++k) {
    if (k != owner && (effects_[k]->of_rows || !(of_law || in_terms))) same[k] = e.fills[k];
  }
  return rightHandSide(t, fills(t, p, std::move(same)), theta);
}

void ActuatorRegression::evaluate(std::span<const double> theta, Eigen::VectorXd& residual,
                                  Eigen::MatrixXd* jacobian) const {
  const Index n = rows();
  const auto linear = static_cast<Index>(linear_);
  const std::span<const double> p = theta.subspan(linear_);
  const Terms law = lawTerms(p);
  if (jacobian == nullptr) {
    double delay = 0.0;
    residual = (predict(law, theta, delay) - data_->rows.effort).matrix();
    blank(residual, counted(delay));
    return;
  }
  const Evaluation e = columns(law, p, /*slopes_too=*/true);
  const Saturation& saturation = e.terms.shared.saturation;
  const Eigen::VectorXd x_c = e.x * Eigen::Map<const Eigen::VectorXd>(theta.data(), linear);
  const auto viscous = static_cast<Index>(viscous_);
  const ArrayXd for_speed = saturation.acts() ? ArrayXd(theta[viscous_] * e.x.col(viscous).array()) : ArrayXd();
  double delay = e.terms.shared.delay;
  const ArrayXd predicted = implicit_           ? predict(law, theta, delay)
                            : saturation.acts() ? saturation.effort(x_c.array(), for_speed)
                                                : ArrayXd(x_c.array());
  residual = (predicted - data_->rows.effort).matrix();
  jacobian->resize(n, static_cast<Index>(parameters_.size()));
  if (saturation.acts()) {
    jacobian->leftCols(linear) = (e.x.array().colwise() * saturation.slope(x_c.array(), for_speed)).matrix();
    jacobian->col(viscous).array() += e.x.col(viscous).array() * saturation.slopeBySpeed(x_c.array(), for_speed);
  } else {
    jacobian->leftCols(linear) = e.x;
  }
  const auto typicalSize = [&](const ParameterSpec& spec) {
    if (base_.law != nullptr) return 1e-2;
    return std::isfinite(spec.upper - spec.lower) ? 1e-3 * (spec.upper - spec.lower) : 1e-9;
  };
  std::vector<double> moved(theta.begin(), theta.end());
  for (std::size_t i = implicit_ ? 0 : linear_; i < parameters_.size(); ++i) {
    auto column = jacobian->col(static_cast<Index>(i));
    const ParameterSpec& parameter = parameters_[i];
    if (parameter.fixed) {
      column.setZero();
      continue;
    }
    double h = 1e-5 * std::max(std::abs(theta[i]), typicalSize(parameter));
    if (theta[i] + h > parameter.upper) h = -h;
    moved[i] = theta[i] + h;
    column = ((predictBeside(e, law, moved, i, h) - predicted) / h).matrix();
    moved[i] = theta[i];
  }
  const std::vector<bool> keep = counted(delay);
  blank(residual, keep);
  blank(*jacobian, keep);
}

}  // namespace simgap
