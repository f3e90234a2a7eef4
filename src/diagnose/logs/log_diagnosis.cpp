#include "simgap/diagnose/logs/log_diagnosis.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "channel_dependence.h"
#include "findings.h"
#include "held_out.h"
#include "log_causes.h"
#include "log_evidence.h"
#include "log_faults.h"
#include "self_test.h"
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
    const auto middle = squares.begin() + static_cast<std::ptrdiff_t>(squares.size() / 2);
    std::nth_element(squares.begin(), middle, squares.end());
    const double sd = *middle / 0.6745 / std::sqrt(2.0);
    if (sd * sd < 1.05 * floor) break;
    floor = sd * sd;
  }
  return floor;
}

constexpr double kStructure = 0.05;       // share of the error that forests have to explain to count as structure
constexpr std::size_t kLargestGroup = 3;  // of causes that cannot be told apart; more is no answer

/// "bend-friction, current-bias or joint-gravity"
std::string namesOf(const std::vector<Cause>& causes) {
  std::vector<std::string> names;
  for (const Cause& cause : causes) {
    std::string name = cause.effect;
    for (const std::string& other : cause.ambiguous_with) name += " or " + other;
    names.push_back(name);
  }
  return fmt::format("{}", fmt::join(names, ", "));
}

/// What is left over, and by which channel; empty when it is no structure.
std::string leftText(const Diagnosis& d) {
  if (d.left_over_percent < 1.0) return {};
  const std::string channel = d.unexplained.empty() ? "the logged channels" : d.unexplained[0].channel;
  const std::string shape =
      d.unexplained.empty() || d.unexplained[0].shape.empty() ? "" : fmt::format(" ({})", d.unexplained[0].shape);
  return fmt::format("{:.0f} % of the squared error, by {}{}", d.left_over_percent, channel, shape);
}

/// What was found is one statement, what is left another: nothing that was found is unsaid because more is there.
void conclude(Diagnosis& d) {
  const bool grouped = std::ranges::any_of(d.causes, [](const Cause& cause) { return !cause.ambiguous_with.empty(); });
  const std::string left = leftText(d);
  if (d.causes.empty()) {
    d.verdict = left.empty() ? DiagnosisVerdict::kNothingFound : DiagnosisVerdict::kUnexplained;
    d.sentence = left.empty() ? fmt::format(
                                    "Nothing found: no cause improves the model on data it has not seen; RMS {:.4g}, "
                                    "noise floor {:.4g}.",
                                    std::sqrt(d.baseline.mse_heldout), std::sqrt(d.noise_floor))
                              : fmt::format("Unexplained: no cause of the catalogue was found. Left: {}.", left);
    return;
  }
  d.verdict = grouped ? DiagnosisVerdict::kAmbiguous : DiagnosisVerdict::kCauseFound;
  d.sentence = fmt::format("Found{}: {} ({:.0f} % of the squared error on data never used). Left: {}.",
                           grouped ? ", but not alone" : "", namesOf(d.causes), d.explained_percent,
                           left.empty() ? "nothing that the logged channels show" : left);
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
    if (d.unexplained[0].channel == "time")
      return "Repeat the first motion at the end of the log and once in its middle: that tells a drift from chance.";
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

/// How the residual follows a channel, from its bins: correlation with the channel or with the distance from its
/// middle.
std::string shapeOf(const std::vector<EvidenceBin>& evidence, const std::string& channel) {
  constexpr double kPlain = 0.8;
  std::vector<const EvidenceBin*> bins;
  for (const EvidenceBin& bin : evidence) {
    if (bin.against.starts_with(channel) && std::isfinite(bin.after)) bins.push_back(&bin);
  }
  if (bins.size() < 5) return {};
  Eigen::ArrayXd x(std::ssize(bins)), y(std::ssize(bins));
  for (Eigen::Index k = 0; k < x.size(); ++k) {
    x[k] = bins[static_cast<std::size_t>(k)]->center;
    y[k] = bins[static_cast<std::size_t>(k)]->after;
  }
  const auto correlation = [&](const Eigen::ArrayXd& of) {
    const Eigen::ArrayXd a = of - of.mean(), b = y - y.mean();
    return (a * b).sum() / std::max(std::sqrt(a.square().sum() * b.square().sum()), 1e-300);
  };
  if (std::abs(correlation(x)) > kPlain) return correlation(x) > 0.0 ? "rises with it" : "falls with it";
  const Eigen::ArrayXd away = (x - 0.5 * (x.minCoeff() + x.maxCoeff())).abs();
  return std::abs(correlation(away)) > kPlain ? "differs between its middle and its ends" : "";
}

/// What a look outside the catalogue and forests say is left, as shares of the baseline's error that add up.
void sayWhatIsLeft(const Selection& selection, const PreparedLog& log, const Ceiling& left, Diagnosis& d) {
  const double unnamed = selection.unnamed ? std::max(0.0, selection.unnamed->gain->value) : 0.0;
  const double forests = left.share > kStructure ? left.share : 0.0;
  const double remaining = 1.0 - 0.01 * d.explained_percent;
  d.left_over_percent = 100.0 * remaining * std::min(1.0, std::max(unnamed, forests));
  std::vector<Leftover> list;
  if (selection.unnamed) {
    const std::vector<double>& fixed = selection.unnamed->hypothesis.fixed;
    for (const double channel : {fixed[2], fixed[3]}) {
      if (channel >= 0.0) list.push_back({log.context[static_cast<std::size_t>(channel)].name, unnamed, {}});
    }
  }
  for (const Leftover& l : left.channels) {
    const bool known = std::ranges::any_of(list, [&](const Leftover& other) { return other.channel == l.channel; });
    if (!known && forests > 0.0 && l.share > 0.0) list.push_back(l);
  }
  double sum = 0.0;
  for (const Leftover& l : list) sum += l.share;
  for (Leftover& l : list) {
    l.share *= 0.01 * d.left_over_percent / std::max(sum, 1e-300);
    l.shape = shapeOf(d.evidence, l.channel);
  }
  if (d.left_over_percent > 0.0) d.unexplained = std::move(list);
}

/// Groups too large to be an answer are candidates, all of them.
void dropLargeGroups(const LogSearch& search, std::size_t own, Selection& selection, Diagnosis& d) {
  for (std::size_t k = selection.steps.size() - 1; k-- > 0;) {
    if (selection.ambiguous_with[k].size() + 1 <= kLargestGroup) continue;
    const std::string reason =
        fmt::format("cannot be told apart here from {}", fmt::join(selection.ambiguous_with[k], ", "));
    d.candidates.push_back({std::string(selection.chosen.model->effects()[own + k]->name), {}, reason, {}});
    dropCause(search, own, k, selection);
  }
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
    d.baseline = d.extended = {std::nan(""), std::nan("")};  // nothing was fitted
    d.noise_floor = d.explained_percent = d.explainable_percent = std::nan("");
    d.sentence = "Data fault: " + std::ranges::find(d.faults, false, &DataFault::corrected)->sentence + ".";
    d.next_experiment = "Mend or leave out these rows and diagnose again, or go on with --ignore-faults.";
    return result;
  }
  Selection selection = selectCauses(search, subject.effects, named, unnamed, options, progress);
  d.hypotheses = selection.records;
  dropLargeGroups(search, subject.effects.size(), selection, d);
  for (Candidate& candidate : keepFindings(search, log, split, subject.effects.size(), options.seed, selection)) {
    d.candidates.push_back(std::move(candidate));
  }
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
  const double explained = std::max(0.0, 1.0 - d.extended.mse_heldout / d.baseline.mse_heldout);
  d.explained_percent = 100.0 * explained;
  sayWhatIsLeft(selection, log, left, d);
  d.explainable_percent = 100.0 * std::max(whole.share, explained + (1.0 - explained) * left.share);
  d.detectable = detectable(search, selection.last, options.least_gain, d.effective_samples);
  if (options.self_tests > 0) {
    d.self_test = runSelfTest(subject, log, after, named, unnamed, d.detectable, d.effective_samples, options,
                              split.training, progress);
  }
  conclude(d);
  addTransmission(subject, log, split, options, result);
  warnOfHarm(d);
  d.extensions = result.extended.extensions;
  d.next_experiment = nextExperiment(d, log);
  return result;
}

}  // namespace simgap
