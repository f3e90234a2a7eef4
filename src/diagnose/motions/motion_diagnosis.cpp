#include "motion_diagnosing.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "diagnose/verdict.h"
#include "motion_candidates.h"
#include "motion_evidence.h"
#include "motion_faults.h"
#include "simgap/core/error.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr std::size_t kFewestSelecting = 4, kFewestJudging = 3;
constexpr double kClearEvidence = 12.0;  // in nats: of some hundred hypotheses one gains 8 by chance
// Of the held-out mean square: so much is explained by no law that is driven by what cannot be right. Where the model
// without the cause is lost, the scan promises no more of the cause than of its placebos; held-out motions are asked
// then.
constexpr double kNoPlacebo = 0.99;
constexpr double kBeyondNoise = 0.25;  // of the noise's variance, that is worth another cause

}  // namespace

/// Looks for faults. \returns whether they end the diagnosis
bool MotionDiagnosing::faulty(const MotionSet& motions, const MotionSet* held_out) {
  const PoseLayout layout = problem_.nominal.poseLayout();
  split_ = splitMotions(motions, held_out, options_.holdout);
  std::vector<DataFault>& faults = result_.diagnosis.faults;
  for (const MotionSet* set : {&motions, held_out}) {
    if (set == nullptr) continue;
    for (const std::string& note : set->notes) faults.push_back({"motions", note, 0, 0, 0, true});
  }
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

std::string MotionDiagnosing::doubtOfFound(const FoundCause& found) const {
  const ArmEffect& effect = *found.fit->causes().back().effect;
  const std::vector<Estimate> sizes = found.fit->extensions().back().parameters;
  const std::string doubt = doubtOfSize(effect, sizes);
  if (!doubt.empty() || !effect.command_delay) return doubt;
  return doubtOfDelay(sizes.front(), usualRow(split_.selecting.motions));
}

/// Whether a cause is named: the evidence, its placebos, and motions that took no part. What is not is a candidate.
bool MotionDiagnosing::judge(const MotionCauseFit& base, const FoundCause& found) {
  const ArmCause& arm = found.fit->causes().back();
  const Eigen::MatrixXd before = unseenOf(base), after = unseenOf(*found.fit);
  const Interval gain = heldOutGain(before, after);
  const double of_motions = static_cast<double>(hypotheses_.size()) * chanceOfGain(logGains(before, after)),
               p = gain.lower95 > kNoPlacebo ? std::min(found.p, of_motions) : found.p;
  HypothesisRecord record{
      base.causes().size() + 1, std::string(arm.effect->name), arm.target, gain, p, "", found.evidence};
  if (found.evidence < kClearEvidence) {
    record.outcome = fmt::format("rejected: evidence {:.1f}", found.evidence);
  } else if (p > options_.level) {
    record.outcome = "rejected: no better than its placebos";
  } else if (!(gain.lower95 > 0.0) || gain.value < kLeastMotionGain) {
    record.outcome = "rejected: no sure gain on held-out motions";
  } else if (const std::string doubt = doubtOfFound(found); !doubt.empty()) {
    record.outcome = "rejected: " + doubt;
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
    d.causes.front().gain_heldout = heldOutGain(unseenOf(*plain_), unseenOf(*last_));
    found_.front().evidence = (plain_->objective() - last_->objective()) / variance;
    found_.front().by_motion = (plain_->losses() - last_->losses()) / variance;
  }
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

void MotionDiagnosisOptions::validate() const {
  requireArmEffects(effects);
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
