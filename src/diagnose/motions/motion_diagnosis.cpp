#include "simgap/diagnose/motions/motion_diagnosis.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "candidate_motions.h"
#include "diagnose/verdict.h"
#include "motion_candidates.h"
#include "motion_evidence.h"
#include "motion_faults.h"
#include "motion_heldout.h"
#include "motion_ordinary.h"
#include "motion_selection.h"
#include "simgap/core/error.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr std::size_t kFewestSelecting = 4, kFewestJudging = 3;
constexpr double kClearEvidence = 12.0;  // in nats: of some hundred hypotheses one gains 8 by chance
constexpr double kLeastGain = 0.05;      // of the held-out mean square
// Of the held-out mean square: so much is explained by no law that is driven by what cannot be right. Where the model
// without the cause is lost, the scan promises no more of the cause than of its placebos; held-out motions are asked
// then.
constexpr double kNoPlacebo = 0.99;
constexpr double kLargeRest = 1.5 * 1.5;  // of the noise's variance: what no model of noise leaves
constexpr double kMostOfIt = 95.0;        // [%] of the error that named causes have to explain, if much is left
constexpr double kBeyondNoise = 0.25;     // of the noise's variance, that is worth another cause
constexpr double kOfNamed = 0.01;         // of the error that named causes took: their laws and steps may leave as much

class MotionDiagnosing {
 public:
  MotionDiagnosing(const ArmModel& model, const MotionCalibrationConfig& config, const MotionDiagnosisOptions& options,
                   const DiagnosisProgress& progress)
      : problem_(motionProblem(model, config)), options_(options), progress_(progress) {}
  MotionDiagnosis run(const MotionSet& motions, const MotionSet* held_out);

 private:
  bool faulty(const MotionSet& motions, const MotionSet* held_out);
  void review(MotionSelector& selector);
  void search();
  bool judge(const MotionCauseFit& base, const FoundCause& found);
  bool leavesMore() const;
  void conclude();
  void fillErrors();
  void sayWhatIsLeft();
  void withdrawPartial();
  void forgetCauses();
  bool preferOrdinary();
  void nameOrdinary();
  void keepCandidates();
  Eigen::MatrixXd unseenOf(const MotionCauseFit& fit) const {
    return unseenSquares(fit, fit.here().z, problem_, split_.judging.motions);
  }

  MotionProblem problem_;
  const MotionDiagnosisOptions& options_;
  const DiagnosisProgress& progress_;
  MotionSplit split_;
  std::vector<MotionHypothesis> hypotheses_;
  std::unique_ptr<MotionCauseFit> plain_, last_;  // last_: with all named causes, null without any
  std::vector<FoundCause> found_;                 // named; their fits have moved to last_
  std::vector<MotionCandidate> others_;           // in place of a named cause, and what was not named
  std::optional<OrdinaryShift> shift_;            // named where no cause is
  double explained_of_all_ = 0.0;                 ///< [%] of what the median motion, seen or not, is missed by
  MotionDiagnosis result_;
};

/// Looks for faults. \returns whether they end the diagnosis
bool MotionDiagnosing::faulty(const MotionSet& motions, const MotionSet* held_out) {
  const PoseLayout layout = problem_.nominal.poseLayout();
  split_ = splitMotions(motions, held_out, options_.holdout);
  std::vector<DataFault>& faults = result_.diagnosis.faults;
  for (MotionSet* set : {&split_.selecting, &split_.judging}) {
    std::vector<bool> wrong;
    for (DataFault& fault : findMotionFaults(*set, layout, wrong)) {
      fault.corrected = options_.ignore_faults;
      faults.push_back(std::move(fault));
    }
    std::size_t i = 0;
    std::erase_if(set->motions, [&](const RecordedMotion&) { return wrong[i++]; });
  }
  if (const DataFault* fault = openFault(faults)) {
    result_.diagnosis.verdict = DiagnosisVerdict::kDataFault;
    result_.diagnosis.sentence = fault->sentence;
    result_.diagnosis.next_experiment =
        "mend what is said and record these motions again; --ignore-faults goes on without them";
    return true;
  }
  const auto refuse = [&](const char* what, std::size_t found, std::size_t fewest) {
    throw DataError(fmt::format("{}: found {} motions to {}, expected at least {}{}", motions.file, found, what, fewest,
                                held_out ? "" : " (of one set 30 % judge; --validation-motions gives others)"));
  };
  if (split_.selecting.motions.size() < kFewestSelecting) {
    refuse("select causes with", split_.selecting.motions.size(), kFewestSelecting);
  }
  if (split_.judging.motions.size() < kFewestJudging) {
    refuse("judge them by", split_.judging.motions.size(), kFewestJudging);
  }
  return false;
}

/// Whether a cause is named: the evidence, its placebos, and motions that took no part. What is not is a candidate.
bool MotionDiagnosing::judge(const MotionCauseFit& base, const FoundCause& found) {
  const ArmCause& arm = found.fit->causes().back();
  const Eigen::MatrixXd before = unseenOf(base), after = unseenOf(*found.fit);
  const Eigen::ArrayXd gains = logGains(before, after);
  const Interval gain = gainOf(gains);
  const double of_motions = static_cast<double>(hypotheses_.size()) * chanceOfGain(gains),
               p = gain.lower95 > kNoPlacebo ? std::min(found.p, of_motions) : found.p;
  HypothesisRecord record{
      base.causes().size() + 1, std::string(arm.effect->name), arm.target, gain, p, "", found.evidence};
  if (found.evidence < kClearEvidence) {
    record.outcome = fmt::format("rejected: evidence {:.1f}", found.evidence);
  } else if (p > options_.level) {
    record.outcome = "rejected: no better than its placebos";
  } else if (!(gain.lower95 > 0.0) || gain.value < kLeastGain) {
    record.outcome = "rejected: no sure gain on held-out motions";
  } else {
    record.outcome = fmt::format("accepted: evidence {:.1f}", found.evidence);
  }
  Diagnosis& d = result_.diagnosis;
  std::erase_if(d.hypotheses, [](const HypothesisRecord& r) { return r.outcome == "best"; });
  d.hypotheses.push_back(record);
  if (!record.outcome.starts_with("accepted")) {
    if (found.evidence >= kClearEvidence) {
      d.candidates.push_back({record.effect, record.target, record.outcome.substr(10), gain});
    }
    return false;
  }
  Cause cause;
  cause.effect = record.effect;
  cause.target = record.target;
  cause.sentence = arm.effect->cause;
  cause.gain_heldout = gain;
  cause.p_adjusted = p;
  cause.ambiguous_with = found.rivals;
  d.causes.push_back(std::move(cause));
  return true;
}

/// Whether what motions that took no part are missed by with all that was named is more than noise and than what the
/// model's steps and laws leave of a cause that is named.
bool MotionDiagnosing::leavesMore() const {
  if (!last_) return true;
  const double before = meanSquare(unseenOf(*plain_)), left = meanSquare(unseenOf(*last_));
  return left - 1.0 > std::max(kBeyondNoise, kOfNamed * (before - left));
}

/// Causes one after the other, as long as each is worth naming.
void MotionDiagnosing::search() {
  problem_.motions = split_.selecting.motions;
  std::string stage = "without causes";
  MotionSelector selector(problem_, hypotheses_, options_.seed, options_.level,
                          [&](double done) { progress_(stage, std::min(0.99, done)); });
  plain_ = selector.fitPlain();
  while (result_.diagnosis.causes.size() < options_.max_causes && leavesMore()) {
    stage = fmt::format("cause {}", result_.diagnosis.causes.size() + 1);
    MotionCauseFit& base = last_ ? *last_ : *plain_;
    std::optional<FoundCause> found = selector.step(base, result_.diagnosis.hypotheses);
    if (!found) break;
    const bool named = judge(base, *found);
    if (!named) others_.push_back(candidateOf(*found->fit, "refused"));
    for (MotionCandidate& other : found->others) {
      if (!named) other.role = "refused";
      others_.push_back(std::move(other));
    }
    if (!named) break;
    last_ = std::move(found->fit);
    found_.push_back(std::move(*found));
    review(selector);
  }
  result_.rollouts = selector.rollouts();
}

/// A cause that was named first may have stood for one that was found beside it: what is not missed is taken back.
void MotionDiagnosing::review(MotionSelector& selector) {
  Diagnosis& d = result_.diagnosis;
  for (std::size_t c = 0; c + 1 < d.causes.size();) {
    std::unique_ptr<MotionCauseFit> without = selector.without(*last_, c);
    const double variance = std::max(1.0, last_->misfit());
    if (!without || (without->objective() - last_->objective()) / variance >= kClearEvidence) {
      ++c;
      continue;
    }
    d.candidates.push_back({d.causes[c].effect, d.causes[c].target,
                            fmt::format("explains nothing beside {}", d.causes.back().effect),
                            d.causes[c].gain_heldout});
    d.causes.erase(d.causes.begin() + static_cast<std::ptrdiff_t>(c));
    found_.erase(found_.begin() + static_cast<std::ptrdiff_t>(c));
    last_ = std::move(without);
    if (d.causes.size() > 1) continue;
    // What it gains was measured beside the one that went.
    d.causes.front().gain_heldout = gainOf(logGains(unseenOf(*plain_), unseenOf(*last_)));
    found_.front().evidence = (plain_->objective() - last_->objective()) / variance;
    found_.front().by_motion = (plain_->losses() - last_->losses()) / variance;
  }
}

void MotionDiagnosing::fillErrors() {
  const MotionCauseFit& after = last_ ? *last_ : *plain_;
  Diagnosis& d = result_.diagnosis;
  const Eigen::MatrixXd seen_before = groupSquares(plain_->posterior(), plain_->here().at),
                        seen_after = groupSquares(after.posterior(), after.here().at), before = unseenOf(*plain_),
                        unseen = unseenOf(after);
  d.error_unit = "noise2";
  d.noise_floor = 1.0;
  d.samples = split_.selecting.motions.size() + split_.judging.motions.size();
  d.effective_samples = static_cast<double>(d.samples);
  d.baseline = {meanSquare(seen_before), meanSquare(before)};
  d.extended = {meanSquare(seen_after), meanSquare(unseen)};
  d.explained_percent = 100.0 * explainedShare(before, unseen);
  Eigen::MatrixXd all_before(before.rows(), seen_before.cols() + before.cols()), all_after = all_before;
  all_before << seen_before, before;
  all_after << seen_after, unseen;
  explained_of_all_ = 100.0 * explainedShare(all_before, all_after);
  d.explainable_percent = 100.0 * std::max(0.0, 1.0 - 1.0 / d.baseline.mse_heldout);
  result_.baseline = plain_->model();
  result_.model = after.model();
  result_.held_out = split_.judging;
  const MotionOptions& playing = problem_.options.motion;
  const auto play = [&](const MotionCauseFit& fit, const MotionSet& set) {
    return playAll(fit.model(), set.motions, playing, fit.posterior().captureDelay(fit.here().z));
  };
  result_.before = play(*plain_, split_.judging);
  result_.after = play(after, split_.judging);
  const std::vector<PlayedMotion> selected = play(after, split_.selecting);
  const auto say = [&](const MotionSet& set, bool held_out, const Eigen::MatrixXd& was, const Eigen::MatrixXd& is,
                       const std::vector<PlayedMotion>& played) {
    for (std::size_t m = 0; m < set.motions.size(); ++m) {
      const auto column = static_cast<Eigen::Index>(m);
      double evidence = held_out ? std::nan("") : 0.0;
      for (const FoundCause& found : found_)
        evidence += found.by_motion[held_out ? 0 : column] * (held_out ? 0.0 : 1.0);
      result_.motions.push_back({set.motions[m].name, held_out, was.col(column).mean(), is.col(column).mean(), evidence,
                                 worstMoment(set.motions[m], played[m], result_.layout)});
    }
  };
  say(split_.selecting, false, seen_before, seen_after, selected);
  say(split_.judging, true, before, unseen, result_.after);
  // Drives that saturate leave more in the currents than a model does; joints and shafts show what is missing.
  for (Eigen::Index g = 0; g + 1 < unseen.rows(); ++g) {
    const double left = unseen.row(g).mean();
    if (!(left > kLargeRest)) continue;
    const std::string name = g + 2 < unseen.rows() ? "joint " + result_.layout.joints[g].name : std::string("shafts");
    d.unexplained.push_back({name, 1.0 - 1.0 / left, ""});
    d.left_over_percent += 100.0 * (left - 1.0) / static_cast<double>(unseen.rows()) / d.baseline.mse_heldout;
  }
}

void MotionDiagnosing::sayWhatIsLeft() {
  Diagnosis& d = result_.diagnosis;
  const auto worst = std::ranges::max_element(
      result_.motions, {}, [](const MotionSay& say) { return std::isfinite(say.after) ? say.after : kInfinity; });
  std::vector<std::string> channels;
  for (const Leftover& left : d.unexplained) channels.push_back(left.channel);
  d.sentence = fmt::format(
      "{} is missed by more than noise leaves, and no cause of the catalogue explains it; worst: "
      "{}, {}",
      fmt::join(channels, ", "), worst->motion, worst->worst);
  d.next_experiment = fmt::format(
      "repeat motion {}: what returns at the same moment is the arm's, what does not came "
      "from outside",
      worst->motion);
}

/// A cause that takes a part of an error, of which much is left, may stand for another one that no fit has found. All
/// motions are asked: where an arm may fall to either side, some that no fit has seen fall to the other.
void MotionDiagnosing::withdrawPartial() {
  Diagnosis& d = result_.diagnosis;
  if (d.causes.empty() || d.unexplained.empty() || explained_of_all_ >= kMostOfIt) return;
  for (const Cause& cause : d.causes) {
    d.candidates.push_back({cause.effect, cause.target,
                            fmt::format("explains, with all that was found, only {:.0f} % of what is missing: "
                                        "something else may look like it",
                                        explained_of_all_),
                            cause.gain_heldout});
  }
  forgetCauses();
}

void MotionDiagnosing::forgetCauses() {
  Diagnosis& d = result_.diagnosis;
  others_.insert(others_.begin(), candidateOf(*last_, "refused"));
  for (MotionCandidate& other : others_) other.role = "refused";
  d.causes.clear();
  last_.reset();
  found_.clear();
  d.unexplained.clear();
  d.left_over_percent = 0.0;
  result_.motions.clear();
  fillErrors();
}

/// What an ordinary parameter explains: beside the named causes it still lies far from what was expected, and they take
/// less of what held-out motions are missed by than its law may leave of what it takes. Damping of a cord that is five
/// times as large is not quite a cord's that relaxes at once, which explains a part of what a bound leaves. \returns
/// whether it is named
bool MotionDiagnosing::preferOrdinary() {
  Diagnosis& d = result_.diagnosis;
  if (!last_ || d.causes.empty() || !options_.effects.empty()) return false;
  const std::optional<OrdinaryShift> shift = furthestShift(*last_);
  if (!shift) return false;
  const Eigen::MatrixXd with = unseenOf(*last_),
                        back = unseenSquares(*last_, shift->back, problem_, split_.judging.motions);
  const double of_causes = meanSquare(unseenOf(*plain_)) - meanSquare(with),
               of_shift = meanSquare(back) - meanSquare(with);
  if (!(gainOf(logGains(back, with)).lower95 > 0.0) || !(of_causes < kOfNamed * of_shift)) return false;
  for (const Cause& cause : d.causes) {
    d.candidates.push_back(
        {cause.effect, cause.target,
         shift->cause.effect + " lies far from what was expected beside it, and explains nearly all of it",
         cause.gain_heldout});
  }
  forgetCauses();
  return true;
}

/// Where no cause explains anything and nothing is left, what ordinary parameters carry may still be out of the
/// ordinary. Motions that no fit has seen have to say so: they are missed by more with what was expected.
void MotionDiagnosing::nameOrdinary() {
  Diagnosis& d = result_.diagnosis;
  const bool instead = preferOrdinary();
  if (!d.causes.empty() || !d.unexplained.empty() || !options_.effects.empty()) return;
  if (!d.candidates.empty() && !instead) return;
  shift_ = furthestShift(*plain_);
  if (!shift_) return;
  const Eigen::MatrixXd before = unseenSquares(*plain_, shift_->back, problem_, split_.judging.motions);
  const Interval gain = gainOf(logGains(before, unseenOf(*plain_)));
  if (!(gain.lower95 > 0.0) || gain.value < kLeastGain) return;
  shift_->cause.gain_heldout = gain;
  d.causes.push_back(shift_->cause);
  d.baseline.mse_heldout = meanSquare(before);
}

/// For a change of the arm to judge: the named model, what stood in the place of a cause, what was refused.
void MotionDiagnosing::keepCandidates() {
  const MotionCauseFit& named = last_ ? *last_ : *plain_;
  std::vector<MotionCandidate>& kept = result_.candidates;
  kept.push_back(candidateOf(named, "named"));
  std::ranges::move(others_, std::back_inserter(kept));
  if (last_) kept.push_back(candidateOf(*plain_, "without"));
  const Eigen::MatrixXd fitted = groupSquares(named.posterior(), named.here().at);
  result_.reference = referenceOf(fitted, unseenOf(named));
  compareWithFirst(kept, result_.reference.variance);
  if (kept.size() > 1) {
    const double way = wayOf(problem_, kept.front(), split_.judging.motions, result_.reference.variance);
    result_.reference.way = std::max(1.0, way);
  }
  result_.noise = named.posterior().noise();
  for (const std::size_t m : someMotions(split_.selecting.motions.size())) {
    result_.profile.push_back(split_.selecting.motions[m]);
  }
}

void MotionDiagnosing::conclude() {
  Diagnosis& d = result_.diagnosis;
  fillErrors();
  withdrawPartial();
  nameOrdinary();
  if (last_) {
    d.extensions = last_->extensions();
    fillParameters(d, split_.selecting);
    d.causes.front().absorbed_by = shiftsBetween(*plain_, *last_);
  }
  keepCandidates();
  d.evidence = errorsOverTime(split_.judging, result_.before, result_.after, result_.layout);
  d.verdict = verdictOf(d.causes, !d.unexplained.empty());
  if (!d.causes.empty()) {
    const Cause& first = d.causes.front();
    const std::string name = first.target.empty() ? first.effect : first.effect + ":" + first.target;
    std::vector<std::string> group = first.ambiguous_with;
    group.insert(group.begin(), name);
    d.sentence = first.ambiguous_with.empty() ? first.sentence
                 : isLost(first.ambiguous_with)
                     ? "something of the catalogue is missing, but too many causes would explain it alike"
                     : fmt::format("one of {}: these motions do not tell which", fmt::join(group, ", "));
    const ArmEffect* effect = findArmEffect(first.effect);
    d.next_experiment = std::string(effect ? effect->separates_by : shift_->separates_by);
  } else if (!d.unexplained.empty()) {
    sayWhatIsLeft();
  } else {
    d.sentence = "no cause of the catalogue improves the model on motions it has not seen";
    d.next_experiment =
        "nothing to separate; faster and slower movements, under more and less co-contraction, would show smaller "
        "causes";
  }
  warnOfHarm(d);
}

MotionDiagnosis MotionDiagnosing::run(const MotionSet& motions, const MotionSet* held_out) {
  result_.layout = problem_.nominal.poseLayout();
  result_.model = result_.baseline = problem_.nominal;
  hypotheses_ = motionHypotheses(problem_.nominal, options_.effects, result_.diagnosis.not_testable);
  if (faulty(motions, held_out)) return std::move(result_);
  search();
  conclude();
  return std::move(result_);
}

}  // namespace

void MotionDiagnosisOptions::validate() const {
  for (const std::string& name : effects) {
    if (findArmEffect(name)) continue;
    std::vector<std::string_view> known;
    for (const ArmEffect* effect : arm_effects::all()) known.push_back(effect->name);
    throw ConfigError(fmt::format("--effects: found '{}', expected some of {}", name, fmt::join(known, ", ")));
  }
  const auto refuse = [](const char* what, double found) {
    throw ConfigError(fmt::format("{}: found {}, expected a number between 0 and 1", what, found));
  };
  if (!(level > 0.0 && level < 1.0)) refuse("--level", level);
  if (!(holdout > 0.0 && holdout < 1.0)) refuse("--holdout", holdout);
}

MotionDiagnosis diagnoseMotions(const ArmModel& model, const MotionSet& motions, const MotionSet* held_out,
                                const MotionCalibrationConfig& config, const MotionDiagnosisOptions& options,
                                const DiagnosisProgress& progress) {
  return MotionDiagnosing(model, config, options, progress).run(motions, held_out);
}

}  // namespace simgap
