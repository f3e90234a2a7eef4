#include "simgap/diagnose/log_diagnosis.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "channel_dependence.h"
#include "log_selection.h"
#include "simgap/core/error.h"
#include "simgap/measure/motion.h"

namespace simgap {
namespace {

/// Why an effect cannot be tested on this log; empty when it can.
std::string missingFor(const DriveEffect& effect, const FrictionLaw& law, const DriveData& data,
                       const std::vector<const DriveEffect*>& own) {
  for (const Channel channel : effect.needs) {
    if (!data.has(channel)) return fmt::format("needs {}", toString(channel));
  }
  if (std::ranges::find(own, &effect) != own.end()) return "the model already contains it";
  const auto hasTerm = [&](FrictionBasis basis, FrictionShape shape) {
    return std::ranges::any_of(law.terms, [&](const FrictionTerm& t) { return t.basis == basis && t.shape == shape; });
  };
  const bool offset = hasTerm(FrictionBasis::kDirection, FrictionShape::kSliding) ||
                      hasTerm(FrictionBasis::kDirection, FrictionShape::kAlways);
  const bool in_law = (effect.name == "coulomb-offset" && offset) ||
                      (effect.name == "static-offset" &&
                       (hasTerm(FrictionBasis::kDirection, FrictionShape::kStatic) || !law.hasStribeck())) ||
                      (effect.name == "stribeck" && law.hasStribeck()) ||
                      (effect.name == "load-dependence" && law.needsLoad()) ||
                      (effect.name == "current-bias" && data.offset);
  if (in_law) return fmt::format("part of the law {}, or without meaning in it", law.name);
  if (effect.name == "stiction-ageing" && !law.hasStribeck()) return "needs a law with a Stribeck term";
  if (effect.name == "stiction-ageing" && !(data.rows.rest > 0.5).any()) return "needs rests of 1 s and longer";
  const bool needs_load = effect.name == "load-dependence" || effect.name == "load-nonlinearity" ||
                          effect.name == "backdrive-asymmetry" || effect.name == "torque-constant-heating";
  if (needs_load && data.rows.top_load == 0.0) return "needs a load that changes";
  return {};
}

std::vector<Hypothesis> namedHypotheses(const DriveSubject& subject, const DriveData& data,
                                        const LogDiagnosisOptions& options, Diagnosis& diagnosis) {
  std::vector<Hypothesis> list;
  for (const std::string& name : options.effects) drive_effects::find(name);
  for (const DriveEffect* effect : drive_effects::all()) {
    if (!options.effects.empty() && std::ranges::find(options.effects, effect->name) == options.effects.end()) continue;
    const std::string reason = missingFor(*effect, *subject.law, data, subject.effects);
    if (reason.empty()) {
      list.push_back({effect, {}, {}});
    } else {
      diagnosis.not_testable.push_back({std::string(effect->name), reason});
    }
  }
  return list;
}

/// A dependence on each further channel, and on the product of any two channels.
std::vector<Hypothesis> unnamedHypotheses(PreparedLog& log) {
  const auto add = [&](const std::string& name, const Eigen::ArrayXd& values) {
    const double mean = values.mean(), sd = std::sqrt((values - mean).square().mean());
    if (!(sd > 0.0)) return;
    log.context.push_back({name, values});
    log.data.rows.context.push_back((values - mean) / sd);
  };
  add("motor_velocity", log.data.rows.speed);
  add("external_torque", log.data.rows.load);
  add("time", log.data.rows.time);
  std::vector<Hypothesis> list;
  for (std::size_t a = 0; a < log.context.size(); ++a) {
    list.push_back({&kChannelDependence, log.context[a].name, {0.0, 0.0, static_cast<double>(a), -1.0}});
    for (std::size_t b = a + 1; b < log.context.size(); ++b) {
      list.push_back({&kChannelDependence,
                      log.context[a].name + " x " + log.context[b].name,
                      {0.0, 0.0, static_cast<double>(a), static_cast<double>(b)}});
    }
  }
  return list;
}

struct Split {
  std::vector<Block> training, heldout;
};

Split splitLog(const PreparedLog& log, const LogDiagnosisOptions& options) {
  Split split;
  const auto every = static_cast<std::size_t>(std::max(2.0, std::round(1.0 / std::max(options.holdout, 0.02))));
  for (std::size_t b = 0; b < log.blocks.size(); ++b) {
    bool out = b % every == every / 2;
    if (!options.heldout_rows.empty()) out = options.heldout_rows[log.blocks[b].begin];
    (out ? split.heldout : split.training).push_back(log.blocks[b]);
  }
  if (split.training.size() < 5 || split.heldout.empty()) {
    throw DataError(
        fmt::format("{}: found {} blocks to learn from and {} to hold out, expected at least 5 and 1: record longer, "
                    "or use shorter "
                    "blocks (--block)",
                    log.file, split.training.size(), split.heldout.size()));
  }
  return split;
}

/// Variance of the effort's fast noise, from differences between rows that follow each other within a direction.
double noiseFloor(const DriveData& data, const Fitted& fitted) {
  Eigen::VectorXd residual;
  fitted.model->evaluate(fitted.theta, residual, nullptr);
  const double level = noiseLevel(std::span<const double>(residual.data(), static_cast<std::size_t>(residual.size())));
  static_cast<void>(data);
  return level * level;
}

std::vector<Absorption> absorption(const std::vector<PhysicalParameter>& before,
                                   const std::vector<PhysicalParameter>& after) {
  std::vector<Absorption> list;
  for (const PhysicalParameter& a : after) {
    const auto b = std::ranges::find(before, a.name, &PhysicalParameter::name);
    if (b == before.end() || !(a.sd > 0.0) || a.name == "presliding") continue;
    const double shift = (a.value - b->value) / a.sd;
    if (std::abs(shift) > 2.0) list.push_back({a.name, shift});
  }
  std::ranges::sort(list, std::greater<>{}, [](const Absorption& a) { return std::abs(a.shift_sd); });
  if (list.size() > 5) list.resize(5);
  return list;
}

}  // namespace

LogDiagnosis diagnoseLog(const DriveSubject& subject, PreparedLog& log, const LogDiagnosisOptions& options,
                         const DiagnosisProgress& progress) {
  LogDiagnosis result;
  Diagnosis& d = result.diagnosis;
  const DriveData& data = log.data;
  d.error_unit = data.effort_unit + "2";
  d.samples = static_cast<std::size_t>(std::ranges::count(data.keep, true));
  const std::vector<Hypothesis> named = namedHypotheses(subject, data, options, d);
  const std::vector<Hypothesis> unnamed = unnamedHypotheses(log);
  const Split split = splitLog(log, options);
  const LogSearch search(*subject.law, data, split.training, options);
  Selection selection = selectCauses(search, subject.effects, named, unnamed, options, progress);
  d.hypotheses = selection.records;
  for (const std::string& name : selection.aliased) {
    d.not_testable.push_back({name, "cannot be told from the model's own parameters on any data of this design"});
  }
  const PieceErrors before = search.errors(selection.baseline, split.heldout);
  d.baseline = {selection.baseline.mse, before.mse()};
  d.extended = {selection.chosen.mse, search.errors(selection.chosen, split.heldout).mse()};
  d.noise_floor = noiseFloor(data, selection.chosen);

  const auto describe = [&](Fitted fitted) {
    DriveFitResult fit;
    const Eigen::MatrixXd covariance = search.refit(fitted, log.blocks);
    fit.effects = fitted.model->effects();
    fit.theta = fitted.theta;
    fit.parameters = fitted.model->physical(fitted.theta, covariance);
    fit.extensions = fitted.model->extensions(fitted.theta, covariance);
    return std::make_pair(fit, fitted);
  };
  auto [baseline, baseline_fit] = describe(selection.baseline);
  auto [extended, extended_fit] = describe(selection.chosen);
  result.baseline = baseline;
  result.extended = extended;
  result.predicted_before = baseline_fit.model->predict(baseline_fit.theta);
  result.predicted_after = extended_fit.model->predict(extended_fit.theta);
  d.extensions = extended.extensions;

  const std::size_t own = subject.effects.size();
  PieceErrors last = before;
  for (std::size_t k = 0; k + 1 < selection.steps.size(); ++k) {
    const DriveEffect& effect = *extended.effects[own + k];
    Cause& cause = d.causes.emplace_back();
    cause.effect = effect.name;
    cause.sentence = effect.cause;
    const PieceErrors now = search.errors(selection.steps[k + 1], split.heldout);
    cause.gain_heldout = pairedGain(last, now, options.seed);
    last = now;
    cause.p_adjusted = selection.p_adjusted[k];
    cause.ambiguous_with = selection.ambiguous_with[k];
    for (const ExtensionParameter& p : extended.extensions[own + k].parameters) {
      const double half = std::isfinite(p.sd) ? 1.96 * p.sd : 0.0;
      cause.parameters.push_back({p.name, p.unit, {p.value, p.value - half, p.value + half}});
    }
    cause.absorbed_by = absorption(baseline.parameters, extended.parameters);
  }
  return result;
}

}  // namespace simgap
