#include "log_causes.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "diagnose/verdict.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

/// How far the parameters moved that were there before.
std::vector<Absorption> shifts(const std::vector<Estimate>& before, const std::vector<Estimate>& after) {
  std::vector<Absorption> list;
  for (const Estimate& a : after) {
    const auto b = std::ranges::find(before, a.name, &Estimate::name);
    if (b == before.end() || !(a.sd > 0.0) || a.name == kNuisance) continue;
    list.push_back({a.name, (a.value - b->value) / a.sd});
  }
  return list;
}

/// Whether an effect's parameter is of a kind.
bool isOf(EffectParameter::Kind kind, const ActuatorEffect& effect, std::string_view parameter) {
  const auto found = std::ranges::find(effect.parameters, parameter, &EffectParameter::name);
  return found != effect.parameters.end() && found->kind == kind;
}

/// A delay has not the residuals' uncertainty alone. Where between two rows a reversal lies, and for how long a held
/// command or a counted position stood, no row says: a reading of that resolution is uncertain by step / sqrt(12)
/// (JCGM 100:2008, F.2.2.1), however many rows repeat it, as all of them err to the same side.
void addResolution(const Fitted& fitted, double step, Eigen::MatrixXd& covariance) {
  for (std::size_t i = 0; i < fitted.theta.size(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    if (fitted.model->isDelay(fitted.theta, i)) covariance(k, k) += step * step / 12.0;
  }
}

}  // namespace

LogFit describe(const LogSearch& search, const PreparedLog& log, Fitted& fitted) {
  return describeFully(search, log, fitted).first;
}

std::pair<LogFit, Eigen::MatrixXd> describeFully(const LogSearch& search, const PreparedLog& log, Fitted& fitted) {
  LogFit fit;
  Eigen::MatrixXd covariance = search.refit(fitted, log.blocks);
  addResolution(fitted, search.step(), covariance);
  fit.effects = fitted.model->effects();
  fit.theta = fitted.theta;
  fit.parameters = fitted.model->physical(fitted.theta, covariance);
  fit.extensions = fitted.model->extensions(fitted.theta, covariance);
  fit.t = studentQuantile(static_cast<double>(log.blocks.size()) - 1.0);
  return {fit, covariance};
}

void addDetectable(const LogSearch& search, const std::vector<Trial>& trials, double least_gain,
                   double effective_samples, Diagnosis& d) {
  const double factor = detectionFactor(least_gain, effective_samples);
  std::set<std::string_view> known;
  for (const Trial& trial : trials) {
    if (!trial.identifiable || trial.fitted.theta.empty()) continue;
    const ActuatorRegression& model = *trial.fitted.model;
    const std::size_t e = model.effects().size() - 1;
    const ActuatorEffect& effect = *model.effects()[e];
    if (known.contains(effect.name)) continue;
    const RowEvaluation at(model, trial.fitted.theta);
    const Eigen::MatrixXd covariance = blockCovariance(model, search.pieces(search.training()), at);
    const std::size_t first = effect.columns.empty() ? model.firstParameter(e) : model.firstColumn(e);
    const Estimate p = model.physical(trial.fitted.theta, covariance)[first];
    if (!(p.sd > 0.0)) continue;
    known.insert(effect.name);
    const std::string name = p.name.substr(p.name.find('.') + 1);
    const auto k = static_cast<Eigen::Index>(first);
    // Of the effort, root mean squares over all rows.
    const double change = factor * std::sqrt(covariance(k, k)) * at.jacobian.col(k).norm(),
                 whole = search.data().rows.effort.matrix().norm();
    const bool shown = trial.gain && trial.gain->lower95 > 0.0;  // however far its own size is from being known
    if (change > whole && !shown) {
      d.not_testable.push_back({std::string(effect.name), fmt::format("this log would show a {} of {:.2g} {} and more, "
                                                                      "which is more than the effort itself",
                                                                      name, factor * p.sd, p.unit)});
    } else if (change <= whole) {
      d.detectable.push_back({std::string(effect.name), {}, name, p.unit, factor * p.sd});
    }
  }
}

std::vector<Cause> causesOf(const Selection& selection, const std::vector<GroupErrors>& heldout, const LogFit& baseline,
                            const LogFit& extended, std::size_t own, std::uint64_t seed) {
  std::vector<Cause> causes;
  for (std::size_t k = 0; k + 1 < heldout.size(); ++k) {
    const ActuatorEffect& effect = *extended.effects[own + k];
    Cause& cause = causes.emplace_back();
    cause.effect = effect.name;
    cause.form = effect.form;
    cause.sentence = effect.cause;
    cause.gain_heldout = predictedGain(heldout[k].sum, heldout[k + 1].sum, seed);
    cause.p_adjusted = selection.p_adjusted[k];
    cause.ambiguous_with = selection.ambiguous_with[k];
    for (const Estimate& p : extended.extensions[own + k].parameters) {
      const bool told = p.sd > 0.0 && std::isfinite(p.sd);
      // A shape that changes nothing is none of the cause's: the time of a warm-up, where a temperature was logged.
      if (!told && !p.at_bound && isOf(EffectParameter::Kind::kShape, effect, p.name)) continue;
      // What was looked for step by step has no derivative to tell its interval by: none is stated.
      const bool scanned = isOf(EffectParameter::Kind::kScanned, effect, p.name);
      cause.parameters.push_back(withInterval(p, told && !scanned ? extended.t * p.sd : std::nan("")));
    }
    cause.absorbed_by = absorbed(shifts(baseline.parameters, extended.parameters));
  }
  return causes;
}

}  // namespace simgap
