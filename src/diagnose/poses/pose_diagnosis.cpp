#include "simgap/diagnose/poses/pose_diagnosis.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "diagnose/far_parameters.h"
#include "diagnose/paired_error.h"
#include "diagnose/verdict.h"
#include "held_out_poses.h"
#include "pose_advice.h"
#include "pose_candidates.h"
#include "pose_conclusion.h"
#include "pose_evidence.h"
#include "pose_score.h"
#include "pose_selection.h"
#include "pose_self_test.h"
#include "pose_validation.h"
#include "simgap/core/csv.h"
#include "simgap/core/error.h"

namespace simgap {
namespace {

constexpr double kLeastOdds = 1.0;  // log, of causes by all poses together

double mean(const Eigen::ArrayXd& values) { return values.size() > 0 ? values.mean() : 0.0; }

class Diagnosing {
 public:
  Diagnosing(const ArmModel& model, const PoseSet& set, const std::vector<ParameterSpace::Choice>& parameters,
             const PoseNoise& noise, const PoseDiagnosisOptions& options, const DiagnosisProgress& progress)
      : problem_{model, parameters, noise, options.threads}, set_(set), options_(options), progress_(progress) {}

  PoseDiagnosis run();

 private:
  void say(std::string_view what) {
    const double total = 6.0 + static_cast<double>(options_.max_causes);
    const double share = options_.self_test > 0 ? 0.0 : std::min(1.0, static_cast<double>(done_++) / total);
    progress_(std::string(what), share);
  }
  Eigen::VectorXd fitPlain();
  void leaveOut();
  void takeBack(const PoseProblem& without);
  void forgetAll();
  void forget(std::size_t cause);
  void makeCandidate(std::size_t cause, std::string reason);
  void forgetHarmful(const PoseProblem& without);
  void forgetPartial(const PoseProblem& without);
  void forgetUndetermined(const PoseProblem& without);
  void measureGain(const PoseProblem& without);
  void fillCauses();
  void fillAbsorption(PoseFit& plain, PoseFit& fit);
  std::string poseErrorsCsv(const ArmModel& before, const ArmModel& after) const;

  PoseProblem problem_;
  const PoseSet& set_;
  const PoseDiagnosisOptions& options_;
  const DiagnosisProgress& progress_;
  std::size_t done_ = 0;
  Split split_;
  std::vector<ArmHypothesis> hypotheses_;
  PoseSelection selection_;
  bool partial_ = false;  ///< causes were taken back since too much is left beside them
  PoseDiagnosis result_;
};

/// Fits the model without causes to the poses of the selection and looks for faults in all. \returns where later fits
/// start
Eigen::VectorXd Diagnosing::fitPlain() {
  const std::vector<bool> heldout = chooseHeldout(set_.poses.size(), options_.holdout);
  std::vector<bool> faulty(set_.poses.size(), false);
  split_ = splitPoses(set_, heldout, faulty);
  PoseFit fit(problem_, split_.selection, {});
  if (!fit.search(options_.starts, problem_.threads, options_.seed)) {
    // Some pose has no equilibrium at any start: the fit begins without those, and they are looked at again below.
    std::vector<Pose> solvable;
    const std::vector<bool> without = fit.withoutEquilibrium();
    for (std::size_t p = 0; p < without.size(); ++p) {
      if (!without[p]) solvable.push_back(split_.selection[p]);
    }
    PoseFit some(problem_, solvable, {});
    if (solvable.size() < kFewestPoses || !some.search(options_.starts, problem_.threads, options_.seed)) {
      throw NumericsError(fmt::format("{}: no parameters of the model give every pose an equilibrium", set_.file));
    }
    fit.setSolution(some.z());
  }
  PoseFit everywhere(problem_, set_.poses, {});
  everywhere.posterior().whiten(fit.z());
  everywhere.setSolution(fit.z());
  result_.diagnosis.faults = findPoseFaults(everywhere, problem_.noise.capture_sd, faulty);
  for (DataFault& fault : result_.diagnosis.faults) fault.corrected |= options_.ignore_faults;
  split_ = splitPoses(set_, heldout, faulty);
  if (split_.selection.size() < kFewestPoses) {
    throw DataError(fmt::format("{}: found {} poses to select causes with, expected at least {}", set_.file,
                                split_.selection.size(), kFewestPoses));
  }
  return fit.z();
}

/// Poses that the model has no rest near once the causes are in it take no part in what follows.
void Diagnosing::leaveOut() {
  if (selection_.left_out.empty()) return;
  for (std::vector<Pose>* poses : {&split_.selection, &split_.all}) {
    std::erase_if(*poses, [&](const Pose& pose) {
      return std::ranges::find(selection_.left_out, pose.name) != selection_.left_out.end();
    });
  }
  result_.diagnosis.warnings.push_back(
      fmt::format("poses without a rest of the model near them once causes are in it were left out: {}",
                  fmt::join(selection_.left_out, ", ")));
}

/// Causes that some poses spoke for and all poses together do not. That looks at the poses held out, but can only make
/// the answer more silent.
void Diagnosing::takeBack(const PoseProblem& without) {
  if (selection_.causes.empty()) return;
  PoseFit plain = fittedFrom(without, split_.all, {}, selection_.z_plain);
  PoseFit fit = fittedFrom(problem_, split_.all, selection_.allCauses(), selection_.z);
  const double odds = fit.logEvidence() - plain.logEvidence();
  if (odds > kLeastOdds) return;
  for (HypothesisRecord& record : selection_.records) {
    if (record.outcome.starts_with("accepted"))
      record.outcome = fmt::format("rejected: log odds {:.1f} by all poses", odds);
  }
  forgetAll();
}

void Diagnosing::forgetAll() {
  selection_.causes.clear();
  selection_.z = selection_.z_plain;
  selection_.stray = selection_.stray_plain;
  selection_.excess = selection_.excess_plain;
  problem_.stray_friction = selection_.stray;
}

/// Takes a cause out of the model.
void Diagnosing::forget(std::size_t cause) {
  if (selection_.causes.size() == 1) return forgetAll();
  PoseFit with(problem_, split_.selection, selection_.allCauses());
  with.setSolution(selection_.z);
  const Eigen::VectorXd z = with.solutionWithout(cause);
  selection_.causes.erase(selection_.causes.begin() + static_cast<std::ptrdiff_t>(cause));
  selection_.z = fittedFrom(problem_, split_.selection, selection_.allCauses(), z).z();
}

/// A cause that is no finding: the reason is said, and a change of the arm may still be asked about it.
void Diagnosing::makeCandidate(std::size_t cause, std::string reason) {
  const AcceptedCause& accepted = selection_.causes[cause];
  const std::string effect(accepted.cause.effect->name);
  result_.diagnosis.candidates.push_back(
      {effect, accepted.cause.target, std::move(reason), result_.diagnosis.causes[cause].gain_heldout});
  selection_.refused.insert(selection_.refused.begin(), accepted.cause);
  for (HypothesisRecord& record : selection_.records) {
    if (record.outcome.starts_with("accepted") && record.effect == effect && record.target == accepted.cause.target)
      record.outcome = "candidate";
  }
}

/// Causes for which the poses held out do not speak, the worst first: without it others may gain.
void Diagnosing::forgetHarmful(const PoseProblem& without) {
  if (!(result_.diagnosis.baseline.mse_heldout > 0.0)) return;  // none was held out that could tell
  std::vector<Cause>& causes = result_.diagnosis.causes;
  while (!causes.empty()) {
    const auto worst = std::ranges::min_element(causes, {}, [](const Cause& c) { return c.gain_heldout.value; });
    if (worst->gain_heldout.value > 0.0) return;
    const auto cause = static_cast<std::size_t>(worst - causes.begin());
    makeCandidate(cause, "the poses held out become no better with it");
    forget(cause);
    measureGain(without);
  }
}

/// Causes that take a part of an error of which much is left: what has no name may look like them.
void Diagnosing::forgetPartial(const PoseProblem& without) {
  Diagnosis& d = result_.diagnosis;
  if (d.causes.empty()) return;
  PoseProblem stated = problem_;
  stated.stray_friction = std::min(1.0, problem_.stray_friction);
  PoseFit fit(stated, split_.all, selection_.allCauses());
  fit.posterior().whiten(selection_.z);
  fit.setSolution(selection_.z);
  const double noise = poseNoiseFloor(fit);
  if (!leavesTooMuch(selection_, d, noise)) return;
  partial_ = true;
  const std::string reason = fmt::format(
      "takes away, with all that was found, only {:.0f} % of an error of which {:.1f} times the noise is left",
      100.0 * (1.0 - d.extended.mse_heldout / d.baseline.mse_heldout), leftInNoise(d, noise));
  for (std::size_t c = 0; c < selection_.causes.size(); ++c) makeCandidate(c, reason);
  forgetAll();
  measureGain(without);
}

/// Causes of which all poses together leave open whether there is any.
void Diagnosing::forgetUndetermined(const PoseProblem& without) {
  while (!selection_.causes.empty()) {
    PoseFit fit = fittedFrom(problem_, split_.all, selection_.allCauses(), selection_.z);
    const std::vector<Extension> found = fit.extensions();
    std::size_t c = 0;
    std::string doubt;
    for (; c < selection_.causes.size() && doubt.empty(); ++c) {
      doubt = doubtOfSize(*selection_.causes[c].cause.effect, found[c].parameters);
    }
    if (doubt.empty()) return;
    makeCandidate(c - 1, doubt);
    forget(c - 1);
    measureGain(without);
  }
}

/// Errors on the poses held out, without causes and with ever more of them.
void Diagnosing::measureGain(const PoseProblem& without) {
  Diagnosis& d = result_.diagnosis;
  fillCauses();
  PoseFit plain(without, split_.selection, {});
  plain.posterior().whiten(selection_.z_plain);
  plain.setSolution(selection_.z_plain);
  const PoseErrors heldout(without, plain, split_.heldout), fitted(without, plain, split_.selection);
  const Eigen::ArrayXd before = heldout.of(plain.model());
  d.extended = d.baseline = {mean(fitted.of(plain.model())), mean(before)};
  Eigen::ArrayXd last = before;
  for (std::size_t c = 0; c < selection_.causes.size(); ++c) {
    const PoseFit fit = fittedFrom(problem_, split_.selection, selection_.firstCauses(c + 1), selection_.z);
    const Eigen::ArrayXd now = heldout.of(fit.model());
    // Of the baseline's error: what this cause takes away from what the causes before it left.
    if (before.size() > 0) d.causes[c].gain_heldout = predictedGain(before, before - (last - now), options_.seed);
    d.extended = {mean(fitted.of(fit.model())), mean(now)};
    last = now;
  }
}

void Diagnosing::fillCauses() {
  result_.diagnosis.causes.clear();
  for (const AcceptedCause& accepted : selection_.causes) {
    Cause& cause = result_.diagnosis.causes.emplace_back();
    cause.effect = accepted.cause.effect->name;
    cause.target = accepted.cause.target;
    cause.sentence = accepted.cause.effect->cause;
    cause.p_adjusted = accepted.p_adjusted;
    cause.ambiguous_with = accepted.rivals;
  }
}

/// Ordinary parameters that moved when the causes came in, in their standard deviations afterwards.
void Diagnosing::fillAbsorption(PoseFit& plain, PoseFit& fit) {
  const Eigen::MatrixXd covariance =
      fit.curvature().llt().solve(Eigen::MatrixXd::Identity(fit.z().size(), fit.z().size()));
  if (result_.diagnosis.causes.empty()) return;
  std::vector<Absorption> shifts;
  for (std::size_t i = 0; i < fit.ordinary(); ++i) {
    const auto k = static_cast<Eigen::Index>(i);
    shifts.push_back({fit.space().parameters()[i].name, (fit.z()[k] - plain.z()[k]) / std::sqrt(covariance(k, k))});
  }
  result_.diagnosis.causes.back().absorbed_by = absorbed(std::move(shifts));
}

std::string Diagnosing::poseErrorsCsv(const ArmModel& before, const ArmModel& after) const {
  CsvWriter csv({"pose", "held_out", "used", "before_deg", "after_deg"});
  const std::vector<double> old = squaredErrors(before, set_.poses), now = squaredErrors(after, set_.poses);
  const auto among = [](const std::vector<Pose>& poses, const std::string& name) {
    return std::ranges::find(poses, name, &Pose::name) != poses.end() ? 1.0 : 0.0;
  };
  for (std::size_t p = 0; p < set_.poses.size(); ++p) {
    const std::string& name = set_.poses[p].name;
    csv.add(name).add(among(split_.heldout, name)).add(among(split_.all, name));
    csv.add(std::sqrt(old[p])).add(std::sqrt(now[p])).endRow();
  }
  return csv.text();
}

PoseDiagnosis Diagnosing::run() {
  Diagnosis& d = result_.diagnosis;
  d.error_unit = "deg2";
  d.samples = set_.poses.size();
  say("fit without causes");
  const Eigen::VectorXd start = fitPlain();
  d.effective_samples = static_cast<double>(split_.all.size());
  hypotheses_ = poseHypotheses(problem_.nominal, split_.all, options_.effects, d.not_testable);
  selection_ = selectCauses(problem_, split_.selection, hypotheses_, start, options_,
                            [this](std::string_view what) { say(what); });
  leaveOut();
  PoseProblem without = problem_;
  without.stray_friction = selection_.stray_plain;
  problem_.stray_friction = selection_.stray;
  takeBack(without);
  say("gain on held-out poses");
  measureGain(without);
  forgetHarmful(without);
  forgetPartial(without);
  forgetUndetermined(without);
  std::ranges::copy(selection_.candidates, std::back_inserter(d.candidates));
  d.hypotheses = selection_.records;

  PoseFit plain = fittedFrom(without, split_.all, {}, selection_.z_plain);
  PoseFit fit = fittedFrom(problem_, split_.all, selection_.allCauses(), selection_.z);
  d.noise_floor = poseNoiseFloor(fit);
  if (d.extended.mse_heldout > 0.0) d.noise_floor = std::min(d.noise_floor, d.extended.mse_heldout);
  d.extensions = fit.extensions();
  for (std::size_t c = 0; c < d.causes.size(); ++c) {
    const ArmEffect& effect = *selection_.causes[c].cause.effect;
    for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
      const Estimate& p = d.extensions[c].parameters[i];
      const double half = p.sd > 0.0 ? 1.96 * p.sd : std::nan("");  // none of a choice, nor of what is not told
      d.causes[c].parameters.push_back(withIntervalIn(effect.parameters[i], p, half));
    }
  }
  fillAbsorption(plain, fit);
  std::ranges::move(
      farParameters(fit.posterior().parameters(), fit.space(), fit.z(), static_cast<Eigen::Index>(fit.ordinary())),
      std::back_inserter(d.warnings));
  d.explained_percent = 100.0 * (d.baseline.mse_heldout - d.extended.mse_heldout) / d.baseline.mse_heldout;
  // Beyond noise and what the parameters' own uncertainty does to poses they were not fitted to.
  d.explainable_percent = std::max({0.0, d.explained_percent, 100.0 * (1.0 - 1.0 / (1.0 + selection_.excess_plain))});
  d.evidence = poseEvidence(plain, fit);
  d.unexplained = poseLeftovers(fit);
  for (const Leftover& left : d.unexplained) d.left_over_percent = std::max(d.left_over_percent, 100.0 * left.share);
  say("what these poses could reveal");
  d.detectable = detectableMagnitudes(problem_, fit, hypotheses_);
  d.next_experiment = nextPoseExperiment(problem_, fit, selection_, hypotheses_, d.not_testable);
  concludePoses(selection_, split_.heldout.size(), partial_, d);
  warnOfHarm(d);
  result_.candidates = candidateModels(problem_, plain, selection_.stray_plain, fit, selection_);
  result_.excess = selection_.excess;
  for (const Pose& pose : split_.all) result_.used.push_back(pose.name);
  result_.pose_errors = poseErrorsCsv(plain.model(), fit.model());
  result_.model = fit.model();
  const std::size_t given = result_.model.extensions.size() - d.extensions.size();
  std::ranges::copy(d.extensions, result_.model.extensions.begin() + static_cast<std::ptrdiff_t>(given));
  if (options_.self_test > 0)
    d.self_test = selfTestPoses(problem_, plain, hypotheses_, d.detectable, options_, progress_);
  return std::move(result_);
}

}  // namespace

void PoseDiagnosisOptions::validate() const {
  requireArmEffects(effects);
  for (const std::string& effect : effects) {
    if (!findArmEffect(effect)->needs_motion) continue;
    throw ConfigError(
        fmt::format("--effects: found {}, expected effects that steady poses show; it takes --motions", effect));
  }
  if (!(level > 0.0 && level < 1.0))
    throw ConfigError(fmt::format("--level: found {}, expected a number in (0, 1)", level));
  if (!(holdout > 0.0 && holdout < 0.9)) {
    throw ConfigError(fmt::format("--holdout: found {}, expected a fraction in (0, 0.9)", holdout));
  }
}

PoseDiagnosis diagnosePoses(const ArmModel& model, const PoseSet& set,
                            const std::vector<ParameterSpace::Choice>& parameters, const PoseNoise& noise,
                            const PoseDiagnosisOptions& options, const DiagnosisProgress& progress) {
  options.validate();
  requireEnough(set, options);
  return Diagnosing(model, set, parameters, noise, options, progress).run();
}

}  // namespace simgap
