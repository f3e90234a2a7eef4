#include "simgap/diagnose/logs/log_diagnosis.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "channel_dependence.h"
#include "diagnose/verdict.h"
#include "findings.h"
#include "held_out.h"
#include "likely_causes.h"
#include "log_candidates.h"
#include "log_causes.h"
#include "log_conclusion.h"
#include "log_evidence.h"
#include "log_faults.h"
#include "self_test.h"
#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/measure/logs/channel_checks.h"
#include "simgap/optimize/uncertainty.h"
#include "testable.h"
#include "transmission.h"

namespace simgap {
namespace {

constexpr double kChoosing = 0.93;  ///< of the progress

/// A dependence on each further channel, and on the product of any two channels.
std::vector<Hypothesis> unnamedHypotheses(const PreparedLog& log) {
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

/// Variance of the noise whose neighbours correlate: differences over ever longer times stop growing where the noise
/// has forgotten itself, and the motion is still smooth. A robust measure is too large for noise of a few values, as a
/// coarse converter gives it: a floor is nowhere above what is left.
double noiseFloor(const PreparedLog& log, const Eigen::VectorXd& residual) {
  constexpr Eigen::Index kLags[] = {1, 2, 4, 8, 16};
  double floor = 0.0;
  for (const Eigen::Index lag : kLags) {
    std::vector<double> squares;
    for (Eigen::Index i = lag; i < residual.size(); ++i) {
      const auto k = static_cast<std::size_t>(i);
      const auto j = static_cast<std::size_t>(i - lag);
      if (residual[i] == 0.0 || residual[i - lag] == 0.0 || log.data.rows.session[k] != log.data.rows.session[j])
        continue;
      squares.push_back(std::abs(residual[i] - residual[i - lag]));
    }
    if (squares.size() < 100) break;
    const double sd = robustDeviation(std::move(squares)) / std::sqrt(2.0);
    if (sd * sd < 1.05 * floor) break;
    floor = sd * sd;
  }
  return std::min(floor, residual.squaredNorm() /
                             static_cast<double>(std::max<Eigen::Index>(1, (residual.array() != 0.0).count())));
}

/// A pendulum that weighs nothing hangs elsewhere.
void warnOfWeight(const PreparedLog& log, const LogFit& fit, Diagnosis& d) {
  if (!log.data.fits_weight) return;
  const std::string& name = log.data.rig_parameters.front().name;
  const auto weight = std::ranges::find(fit.parameters, name, &Estimate::name);
  if (weight != fit.parameters.end() && weight->at_bound) d.warnings.push_back(weightlessSentence(name));
}

/// Leaves out rows near rest whose direction of motion a first fit cannot decide, then spikes.
void takeOutRows(const ActuatorModel& subject, const LogSearch& search, PreparedLog& log, Diagnosis& d) {
  const Fitted first = search.fit(subject.effects, nullptr);
  Eigen::VectorXd flipped;
  if (subject.base.law != nullptr) {
    ActuatorData backwards = log.data;
    backwards.rows.direction *= -1.0;
    const ActuatorRegression mirror(subject.base, subject.effects, backwards, 1.0);
    mirror.evaluate(mirror.startFrom(*first.model, first.theta), flipped, nullptr);
    if (const std::size_t rows = takeOutUndecided(log, residualOf(first), flipped); rows > 0) {
      d.warnings.push_back(
          fmt::format("{} rows near rest were left out: their direction of motion cannot be decided", rows));
    }
  }
  for (const DataFault& fault : takeOutSpikes(log, residualOf(first), flipped)) d.faults.push_back(fault);
}

std::vector<double> keptOf(const PreparedLog& log, const Eigen::VectorXd& values) {
  std::vector<double> kept;
  for (Eigen::Index i = 0; i < values.size(); ++i) {
    if (log.data.keep[i]) kept.push_back(values[i]);
  }
  return kept;
}

/// Whether most of what is left is the same in all rows.
bool isMostlyConstant(const PreparedLog& log, const Eigen::VectorXd& residual) {
  const std::vector<double> kept = keptOf(log, residual);
  const auto sizes = Eigen::Map<const Eigen::ArrayXd>(kept.data(), std::ssize(kept));
  return 2.0 * sizes.mean() * sizes.mean() > sizes.square().mean();
}

/// Something acts that no channel shows, such as a push or a wind: what is left is mostly no noise, and not by a few
/// outliers.
bool actsUnseen(const PreparedLog& log, const Eigen::VectorXd& residual, double noise_floor) {
  constexpr double kFar = 1.5;        // times the noise
  constexpr double kOutliers = 0.01;  // of the rows
  std::vector<double> squares = keptOf(log, residual);
  for (double& value : squares) value *= value;
  const auto rest =
      squares.begin() + static_cast<std::ptrdiff_t>((1.0 - kOutliers) * static_cast<double>(squares.size()));
  if (noise_floor <= 0.0 || rest == squares.begin()) return false;
  std::ranges::nth_element(squares, rest);
  const double sum = std::accumulate(squares.begin(), rest, 0.0);
  return sum > kFar * kFar * noise_floor * static_cast<double>(rest - squares.begin());
}

/// What is left with the causes, against noise and against anything that the channels could explain.
/// \param before, after  residuals, shape (rows). \param known  what forests explain of `after`, where it is known
/// \returns how many neighbouring rows of `after` are alike
double measureLeft(const Selection& selection, const PreparedLog& log, const Eigen::VectorXd& before,
                   const Eigen::VectorXd& after, const std::optional<Ceiling>& known, std::uint64_t seed,
                   Diagnosis& d) {
  const double correlation = correlationTime(after, log.data.rows.session);
  const double floor = noiseFloor(log, after);
  d.effective_samples = static_cast<double>(d.samples) / correlation;
  const std::vector<EvidenceChannel> channels = evidenceChannels(log);
  d.evidence = binEvidence(log, channels, before, after, correlation);
  const Ceiling left = known ? *known : explainable(log, channels, after, seed);
  // The floor is of all rows; what channels tell of rows that had no part in a fit is no noise, however slow.
  d.noise_floor = std::min(floor, (1.0 - shareLeft(selection, left)) * d.extended.mse_heldout);
  const double explained = std::max(0.0, 1.0 - d.extended.mse_heldout / d.baseline.mse_heldout);
  d.explained_percent = 100.0 * explained;
  d.explainable_percent = 100.0 * (explained + (1.0 - explained) * left.share);
  sayWhatIsLeft(selection, log, left, d);
  const bool unseen = d.unexplained.empty() && actsUnseen(log, after, floor);
  if (unseen) {
    d.left_over_percent = (100.0 - d.explained_percent) * (1.0 - floor / std::max(d.extended.mse_heldout, floor));
    if (isMostlyConstant(log, after)) d.unexplained.push_back({"an offset", 0.01 * d.left_over_percent, ""});
  }
  const double told = unseen && d.unexplained.empty() ? 0.0 : d.left_over_percent;  // by channels, or as an offset
  d.explainable_percent = std::max(d.explainable_percent, d.explained_percent + told);
  return correlation;
}

/// A static term that hardly any row told is without bound in rows that are slower.
void requireBounded(const PreparedLog& log, double mse_heldout) {
  constexpr double kUnbounded = 1e4;  // times the effort's own square
  const double square = log.data.rows.effort.square().mean();
  if (mse_heldout <= kUnbounded * square) return;
  throw NumericsError(
      fmt::format("{}: found an error of {:.2g} times the effort on rows that the law was not fitted to, expected one "
                  "that ends: hardly any row tells its friction in slow motion; take a law without a Stribeck term "
                  "(coulomb, load-coulomb), or record slow motion",
                  log.file, std::sqrt(mse_heldout / square)));
}

}  // namespace

void requireDiagnosable(const PreparedLog& log, const LogDiagnosisOptions& options) {
  for (const std::string& name : options.effects) actuator_effects::find(name);
  const ActuatorRows& rows = log.data.rows;
  for (const auto& [name, driver] : {std::pair("the deflection", &rows.deflection), {"current_A", &rows.current}}) {
    if (driver->size() > 0) requireMotion(log.file, name, spanOf(*driver), spanOf(rows.effort));
  }
  if (log.kind == ActuatorKind::kFriction) {
    requireMoreThanSteps(log.file, log.effort_column, keptOf(log, rows.effort.matrix()));
  }
  static_cast<void>(splitLog(log, options));
}

LogRefit refitLog(const ActuatorModel& subject, const PreparedLog& log) {
  const LogDiagnosisOptions options;
  requireDiagnosable(log, options);
  const LogSearch search(subject.base, log.data, log.blocks, options);
  Fitted fitted = search.fitFrom(subject.effects, subject.values);
  search.validate(fitted);
  LogRefit result;
  result.mse_heldout = fitted.validation.mse();
  result.fit = describe(search, log, fitted);
  result.mse = fitted.mse;
  result.rows = static_cast<std::size_t>(std::ranges::count(log.data.keep, true));
  result.effective_samples =
      static_cast<double>(result.rows) / correlationTime(residualOf(fitted), log.data.rows.session);
  result.predicted = fitted.model->predict(fitted.theta);
  return result;
}

LogDiagnosis diagnoseLog(const ActuatorModel& subject, PreparedLog& log, const LogDiagnosisOptions& options,
                         const DiagnosisProgress& progress) {
  LogDiagnosis result;
  Diagnosis& d = result.diagnosis;
  d.error_unit = log.data.effort_unit + "2";
  d.samples = static_cast<std::size_t>(std::ranges::count(log.data.keep, true));
  d.warnings = log.warnings;
  d.faults = findFaults(log);
  const std::vector<Hypothesis> named = namedHypotheses(subject, log.data, options, d);
  const std::vector<Hypothesis> unnamed = unnamedHypotheses(log);
  const LogSplit split = splitLog(log, options);
  if (openFault(d.faults) == nullptr) {
    takeOutRows(subject, LogSearch(subject.base, log.data, split.training, options), log, d);
  }
  if (const DataFault* fault = openFault(d.faults); fault != nullptr && !options.ignore_faults) {
    endWith(*fault, d);
    d.next_experiment = "Mend or leave out these rows and diagnose again, or go on with --ignore-faults.";
    return result;
  }

  const LogSearch search(subject.base, log.data, split.training, options);
  const DiagnosisProgress choosing = partOfProgress(progress, 0.0, kChoosing);
  Selection selection = selectCauses(search, subject.effects, named, unnamed, options,
                                     partOfProgress(choosing, 0.0, HeldOutParts::kMainShare));
  d.hypotheses = selection.records;
  HeldOutParts parts(search, split.heldout, subject.effects.size());
  if (selection.steps.size() > 1) parts.addOthers(log, subject, named, selection.records, options, choosing);
  Findings found = keepFindings(search, log, parts, subject.effects.size(), named, options, selection);
  d.candidates = std::move(found.candidates);
  for (const std::string& name : selection.aliased) {
    d.not_testable.push_back({name, "the model's own parameters can take its place on this data"});
  }
  d.baseline = {selection.baseline.mse, found.heldout.front().mse()};
  d.extended = {selection.chosen.mse, found.heldout.back().mse()};
  requireBounded(log, d.baseline.mse_heldout);

  if (progress) progress("measuring what is left", kChoosing);
  Fitted before = selection.baseline;
  const Fitted& after = found.on_all_rows;
  result.baseline = describe(search, log, before);
  result.extended = std::move(found.fit);
  warnOfWeight(log, result.baseline, d);
  result.predicted_before = before.model->predict(before.theta);
  result.predicted_after = after.model->predict(after.theta);
  d.causes = causesOf(selection, found.heldout, result.baseline, result.extended, subject.effects.size(), options.seed);
  addLikely(selection, d);
  const double correlation =
      measureLeft(selection, log, residualOf(before), residualOf(after), found.left, options.seed, d);
  addDetectable(search, selection.last, options.least_gain, d.effective_samples, d);
  if (options.self_tests > 0) {
    d.self_test = runSelfTest(subject, log, after, named, unnamed, d.detectable, d.effective_samples, options,
                              split.training, progress);
  }
  conclude(d);
  addTransmission(subject, log, split, options, result);
  warnOfHarm(d);
  d.extensions = result.extended.extensions;
  result.correlation_s = correlation * log.data.rows.step;
  result.candidates = logCandidates(search, log, selection, d.candidates, named, subject.effects.size(), correlation);
  d.next_experiment = nextExperiment(d, log);
  return result;
}

}  // namespace simgap
