#include "simgap/diagnose/logs/log_diagnosis.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "channel_dependence.h"
#include "held_out.h"
#include "log_causes.h"
#include "log_evidence.h"
#include "log_faults.h"
#include "self_test.h"
#include "simgap/core/statistics.h"
#include "simgap/optimize/uncertainty.h"
#include "testable.h"
#include "transmission.h"

namespace simgap {
namespace {

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
/// has forgotten itself, and the motion is still smooth.
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
  return floor;
}

constexpr double kStructure = 0.05;       // share of the error that forests have to explain to count as structure
constexpr std::size_t kLargestGroup = 3;  // of causes that cannot be told apart; more is no answer

void conclude(Diagnosis& d, const Selection& selection, double structure) {
  const bool strange = selection.unnamed.has_value() || structure > kStructure;
  bool grouped = false, lost = false;
  for (const Cause& cause : d.causes) {
    grouped = grouped || !cause.ambiguous_with.empty();
    lost = lost || cause.ambiguous_with.size() + 1 > kLargestGroup;
  }
  const double unnamed_gain = selection.unnamed ? selection.unnamed->gain->value : 0.0;
  const bool mostly_strange = d.causes.empty() ? strange : unnamed_gain > d.causes[0].gain_heldout.value;
  // What was chosen on some blocks and makes others worse explains nothing.
  const bool refuted = !d.causes.empty() && d.extended.mse_heldout >= d.baseline.mse_heldout;
  d.verdict = lost || mostly_strange || refuted ? DiagnosisVerdict::kUnexplained
              : d.causes.empty()                ? DiagnosisVerdict::kNothingFound
              : grouped                         ? DiagnosisVerdict::kAmbiguous
                                                : DiagnosisVerdict::kCauseFound;
  std::vector<std::string> names;
  for (const Cause& cause : d.causes) {
    std::string name = cause.effect;
    for (const std::string& other : cause.ambiguous_with) name += " or " + other;
    names.push_back(name);
  }
  const double gain = 100.0 * (1.0 - d.extended.mse_heldout / d.baseline.mse_heldout);
  const std::string channel = d.unexplained.empty() ? "the logged channels" : d.unexplained[0].channel;
  switch (d.verdict) {
    case DiagnosisVerdict::kCauseFound:
    case DiagnosisVerdict::kAmbiguous:
      d.sentence =
          fmt::format("{}: {}; the extended model's squared error is {:.1f} % lower on data never used.",
                      d.verdict == DiagnosisVerdict::kCauseFound ? "Cause found" : "Cause found, but not alone",
                      fmt::join(names, ", "), gain);
      break;
    case DiagnosisVerdict::kUnexplained:
      if (refuted) {
        d.sentence = fmt::format("Unexplained: {} fits the blocks it was chosen on, but not those held out.",
                                 fmt::join(names, ", "));
        break;
      }
      d.sentence = fmt::format("Unexplained: the error depends on {} in a way that no cause of the catalogue explains.",
                               channel);
      break;
    default:
      d.sentence = fmt::format(
          "Nothing found: no cause improves the model on data it has not seen; RMS {:.4g}, noise "
          "floor {:.4g}.",
          std::sqrt(d.baseline.mse_heldout), std::sqrt(d.noise_floor));
  }
}

std::string nextExperiment(const Diagnosis& d, const PreparedLog& log) {
  const double minutes = log.data.rows.time[log.data.rows.rows() - 1] / 60.0;
  for (const Cause& cause : d.causes) {
    if (cause.ambiguous_with.empty()) continue;
    std::string text = fmt::format("To tell {} from {}: record {}", cause.effect, fmt::join(cause.ambiguous_with, ", "),
                                   actuator_effects::find(cause.effect).separates);
    for (const std::string& other : cause.ambiguous_with) {
      text += fmt::format("; and {}", actuator_effects::find(other).separates);
    }
    if (log.data.rows.top_load == 0.0) return text + ".";
    return text + fmt::format(" ({:.0f} min at loads up to {:.3g} {} would do).", std::max(2.0, 0.2 * minutes),
                              log.data.rows.top_load, log.data.load_unit);
  }
  if (d.verdict == DiagnosisVerdict::kUnexplained && !d.unexplained.empty()) {
    return fmt::format("Repeat one motion and load while {} is stepped up and down over its range: that shows its law.",
                       d.unexplained[0].channel);
  }
  if (!d.causes.empty()) {
    return fmt::format("To confirm {} independently: record {}.", d.causes[0].effect,
                       actuator_effects::find(d.causes[0].effect).separates);
  }
  if (d.verdict != DiagnosisVerdict::kNothingFound) return {};
  return fmt::format(
      "Nothing is missing at this noise; smaller effects than those under `detectable` need about {:.0f} min "
      "of log for half of their size.",
      4.0 * minutes);
}

/// What a look outside the catalogue and forests say is left.
std::vector<Leftover> leftovers(const Selection& selection, const PreparedLog& log, const Ceiling& left) {
  std::vector<Leftover> list;
  if (selection.unnamed) {
    const std::vector<double>& fixed = selection.unnamed->hypothesis.fixed;
    for (const double channel : {fixed[2], fixed[3]}) {
      if (channel >= 0.0)
        list.push_back({log.context[static_cast<std::size_t>(channel)].name, selection.unnamed->gain->value});
    }
  }
  if (left.share < kStructure) return list;
  for (const Leftover& l : left.channels) {
    const bool known = std::ranges::any_of(list, [&](const Leftover& other) { return other.channel == l.channel; });
    if (!known) list.push_back(l);
  }
  return list;
}

}  // namespace

void requireDiagnosable(const PreparedLog& log, const LogDiagnosisOptions& options) {
  for (const std::string& name : options.effects) actuator_effects::find(name);
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
  const auto open = [&] { return std::ranges::any_of(d.faults, [](const DataFault& f) { return !f.corrected; }); };
  const std::vector<Hypothesis> named = namedHypotheses(subject, log.data, options, d);
  const std::vector<Hypothesis> unnamed = unnamedHypotheses(log);
  const LogSplit split = splitLog(log, options);
  const LogSearch search(subject.base, log.data, split.training, options);
  if (!open()) {
    const Fitted first = search.fit(subject.effects, nullptr);
    if (subject.base.law != nullptr) {
      ActuatorData backwards = log.data;
      backwards.rows.direction *= -1.0;
      const ActuatorRegression mirror(subject.base, subject.effects, backwards, 1.0);
      Eigen::VectorXd flipped;
      mirror.evaluate(mirror.startFrom(*first.model, first.theta), flipped, nullptr);
      if (const std::size_t rows = takeOutUndecided(log, residualOf(first), flipped); rows > 0) {
        d.warnings.push_back(
            fmt::format("{} rows near rest were left out: their direction of motion cannot be decided", rows));
      }
    }
    for (const DataFault& fault : takeOutSpikes(log, residualOf(first))) d.faults.push_back(fault);
  }
  if (open() && !options.ignore_faults) {
    d.verdict = DiagnosisVerdict::kDataFault;
    d.sentence = "Data fault: " + std::ranges::find(d.faults, false, &DataFault::corrected)->sentence + ".";
    d.next_experiment = "Mend or leave out these rows and diagnose again, or go on with --ignore-faults.";
    return result;
  }
  const Selection selection = selectCauses(search, subject.effects, named, unnamed, options, progress);
  d.hypotheses = selection.records;
  for (const std::string& name : selection.aliased) {
    d.not_testable.push_back({name, "the model's own parameters can take its place on this data"});
  }
  const std::vector<PieceErrors> heldout = heldOutErrors(search, selection, split.heldout, log.data.rows.session);
  d.baseline = {selection.baseline.mse, heldout.front().mse()};
  d.extended = {selection.chosen.mse, heldout.back().mse()};

  if (progress) progress("measuring what is left", 0.93);
  Fitted before = selection.baseline, after = selection.chosen;
  result.baseline = describe(search, log, before);
  result.extended = describe(search, log, after);
  result.predicted_before = before.model->predict(before.theta);
  result.predicted_after = after.model->predict(after.theta);
  const Eigen::VectorXd residual_before = residualOf(before), residual_after = residualOf(after);
  d.noise_floor = noiseFloor(log, residual_after);
  d.effective_samples = static_cast<double>(d.samples) / correlationTime(residual_after, log.data.rows.session);
  d.causes = causesOf(selection, heldout, result.baseline, result.extended, subject.effects.size(), options.seed);
  const std::vector<EvidenceChannel> channels = evidenceChannels(log);
  d.evidence = binEvidence(log, channels, residual_before, residual_after);
  const Ceiling left = explainable(log, channels, residual_after, options.seed);
  const Ceiling whole = d.causes.empty() ? left : explainable(log, channels, residual_before, options.seed);
  d.unexplained = leftovers(selection, log, left);
  const double explained = std::max(0.0, 1.0 - d.extended.mse_heldout / d.baseline.mse_heldout);
  d.explained_percent = 100.0 * explained;
  d.explainable_percent = 100.0 * std::max(whole.share, explained + (1.0 - explained) * left.share);
  d.detectable = detectable(search, selection.last, options.least_gain, d.effective_samples);
  if (options.self_tests > 0) {
    d.self_test = runSelfTest(subject, log, after, named, unnamed, d.detectable, d.effective_samples, options,
                              split.training, progress);
  }
  conclude(d, selection, left.share);
  addTransmission(subject, log, split, options, result);
  warnOfHarm(d);
  d.extensions = result.extended.extensions;
  d.next_experiment = nextExperiment(d, log);
  return result;
}

}  // namespace simgap
