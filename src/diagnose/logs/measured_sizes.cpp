#include "measured_sizes.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "diagnose/verdict.h"

namespace simgap {
namespace {

using Eigen::Index;
using Kind = EffectParameter::Kind;

constexpr double kCancelling = 30.0;  // times what a cause's terms add up to: each of them alone means nothing
constexpr double kBeyond = 3.0;       // times the largest effort or load: a size that was extrapolated, not measured

/// A size that was measured. With a shape beside it (how fast it heats up) each alone may be known badly where the two
/// together are not: whether the cause is there at all was tested before, here only sizes that mean nothing are
/// refused.
bool isMeasured(const Estimate& p, double neutral, double t) {
  return std::isfinite(p.sd) && p.sd > 0.0 && t * p.sd < kMeaningless * std::abs(p.value - neutral);
}

Eigen::MatrixXd jacobianAt(const ActuatorRegression& model, std::span<const double> theta) {
  Eigen::VectorXd residual;
  Eigen::MatrixXd jacobian;
  model.evaluate(theta, residual, &jacobian);
  return jacobian;
}

/// Whether a parameter changes anything: a warm-up time does not where a temperature was logged.
bool acts(const ActuatorRegression& model, std::span<const double> theta, std::size_t parameter) {
  return jacobianAt(model, theta).col(parameter).squaredNorm() > 0.0;
}

/// The size of a cause's column in the units of the effort, where its unit says one; else 0.
double sizeOf(const ActuatorRegression& model, const Fitted& fitted, std::size_t effect, std::size_t column,
              const ActuatorRows& rows) {
  const std::string_view unit = model.effects()[effect]->columns[column].unit;
  const double theta = std::abs(fitted.theta[model.firstColumn(effect) + column]);
  if (unit == "Nm" || unit == "A") return theta;
  return unit == "1" ? theta * rows.top_load : 0.0;
}

}  // namespace

std::string undetermined(const ActuatorRegression& model, std::span<const double> theta, const LogFit& fit,
                         std::size_t effect) {
  const ActuatorEffect& cause = *model.effects()[effect];
  bool any = false;
  for (std::size_t k = 0; k < cause.columns.size(); ++k) {
    any = any || isMeasured(fit.parameters[model.firstColumn(effect) + k], 0.0, fit.t);
  }
  bool sized = !cause.columns.empty();
  for (std::size_t k = 0; k < cause.parameters.size(); ++k) {
    const EffectParameter& p = cause.parameters[k];
    const Estimate& value = fit.parameters[model.firstParameter(effect) + k];
    if (p.kind == Kind::kScanned || p.kind == Kind::kConstant) continue;
    if (value.at_bound && acts(model, theta, model.firstParameter(effect) + k) &&
        std::abs(value.value - p.neutral) > 1e-9 * (1.0 + std::abs(p.neutral))) {
      return fmt::format("{} ends at the bound {:.4g} of its range", p.name, value.value);
    }
    if (p.kind != Kind::kSmooth) continue;
    sized = true;
    any = any || isMeasured(value, p.neutral, fit.t);
  }
  return any || !sized ? "" : "none of its own parameters is determined by these data";
}

double actionOf(const Fitted& fitted, std::size_t effect, const Eigen::ArrayXd& refitted,
                const Eigen::Array<bool, Eigen::Dynamic, 1>& rows) {
  const ActuatorRegression& model = *fitted.model;
  const ActuatorEffect& cause = *model.effects()[effect];
  std::vector<double> none = fitted.theta;
  for (std::size_t k = 0; k < cause.columns.size(); ++k) none[model.firstColumn(effect) + k] = 0.0;
  for (std::size_t k = 0; k < cause.parameters.size(); ++k)
    none[model.firstParameter(effect) + k] = cause.parameters[k].neutral;
  const auto aboutMean = [&](const Eigen::ArrayXd& change) {
    const double mean = rows.select(change, 0.0).sum() / std::max<double>(1.0, static_cast<double>(rows.count()));
    return rows.select((change - mean).square(), 0.0).sum();
  };
  return std::min(aboutMean(model.predict(fitted.theta) - model.predict(none)), aboutMean(refitted));
}

std::string outOfSight(const ActuatorRegression& model, std::span<const double> theta, std::size_t effect,
                       const ActuatorRows& rows) {
  const ActuatorEffect& cause = *model.effects()[effect];
  const std::span<const double> p = theta.subspan(model.firstParameter(effect), cause.parameters.size());
  if (cause.counts == nullptr || cause.counts(p, rows)) return {};
  std::vector<std::string> sizes;
  for (std::size_t k = 0; k < p.size(); ++k) {
    if (cause.parameters[k].kind != Kind::kConstant)
      sizes.push_back(fmt::format("{} = {:.3g}", cause.parameters[k].name, p[k]));
  }
  return fmt::format("fitted to all rows it is none that such a log could show ({})", fmt::join(sizes, ", "));
}

std::string beyondTheData(const ActuatorRegression& model, const Fitted& fitted, std::size_t effect,
                          const ActuatorRows& rows) {
  const double top = rows.effort.abs().maxCoeff();
  const std::span<const EffectColumn> columns = model.effects()[effect]->columns;
  for (std::size_t k = 0; k < columns.size(); ++k) {
    const double size = sizeOf(model, fitted, effect, k, rows);
    if (size <= kBeyond * top) continue;
    return fmt::format("{} would be {:.2g} times the largest effort of the log", columns[k].name, size / top);
  }
  // A load beside one that is known: what k_a makes up for can be as large as it likes, and only its small rest shows.
  const std::span<const EffectParameter> parameters = model.effects()[effect]->parameters;
  for (std::size_t k = 0; k < parameters.size() && rows.top_load > 0.0; ++k) {
    const double size = std::abs(fitted.theta[model.firstParameter(effect) + k]);
    if (parameters[k].unit != "Nm" || size <= kBeyond * rows.top_load) continue;
    return fmt::format("{} would be {:.2g} times the largest load of the log", parameters[k].name,
                       size / rows.top_load);
  }
  return {};
}

std::string loadThatMayBeNone(const ActuatorRegression& model, const LogFit& fit, std::size_t effect,
                              const ActuatorRows& rows) {
  const std::span<const EffectParameter> parameters = model.effects()[effect]->parameters;
  for (std::size_t k = 0; k < parameters.size() && rows.top_load > 0.0; ++k) {
    const Estimate& p = fit.parameters[model.firstParameter(effect) + k];
    const double half = fit.t * p.sd;
    if (parameters[k].unit != "Nm" || parameters[k].kind != Kind::kSmooth || half < std::abs(p.value)) continue;
    return fmt::format("beside the load that is known {} may be nothing: {:.3g} ± {:.2g}", parameters[k].name, p.value,
                       half);
  }
  return {};
}

std::string loadItReplaces(const Fitted& rest, const Fitted& full, const ActuatorRows& rows) {
  constexpr double kFarLess = 1.5;  // times
  if (!rows.load_measured || rows.top_load == 0.0 || full.theta[0] * kFarLess > rest.theta[0]) return {};
  return fmt::format("it takes the place of the measured load: k_a would be {:.3g} with it, and is {:.3g} without",
                     1.0 / full.theta[0], 1.0 / rest.theta[0]);
}

bool losesStrength(const Fitted& rest, const Fitted& full, std::size_t effect) {
  const auto lost = [](const Fitted& fitted) { return atBound(fitted.model->parameters()[0], fitted.theta[0]); };
  return full.model->parameters()[0].name == "k_a" && lost(full) && !lost(rest) &&
         std::ranges::any_of(full.model->effects()[effect]->columns, &EffectColumn::torque);
}

bool cancels(const ActuatorRegression& model, const Fitted& fitted, std::size_t effect) {
  const std::size_t count = model.effects()[effect]->columns.size();
  if (count < 2) return false;
  const Eigen::MatrixXd jacobian = jacobianAt(model, fitted.theta);
  const auto first = static_cast<Index>(model.firstColumn(effect));
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(jacobian.rows());
  double largest = 0.0;
  for (Index k = first; k < first + static_cast<Index>(count); ++k) {
    const Eigen::VectorXd term = fitted.theta[k] * jacobian.col(k);
    largest = std::max(largest, term.norm());
    sum += term;
  }
  return largest > kCancelling * sum.norm();
}

}  // namespace simgap
