#include "motion_diagnosing.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <iterator>

#include "candidate_motions.h"
#include "diagnose/far_parameters.h"
#include "diagnose/verdict.h"
#include "motion_candidates.h"
#include "motion_evidence.h"

namespace simgap {
namespace {

constexpr double kMostOfIt = 95.0;     // [%] of the error that named causes have to explain, if much is left
constexpr double kNothingElse = 1.25;  // times the noise's mean square: an ordinary parameter takes up what is missing

}  // namespace

void MotionDiagnosing::fillErrors() {
  const MotionCauseFit& after = last_ ? *last_ : *plain_;
  Diagnosis& d = result_.diagnosis;
  const Eigen::MatrixXd seen_before = groupSquares(plain_->posterior(), plain_->here().at),
                        seen_after = groupSquares(after.posterior(), after.here().at), before = unseenOf(*plain_),
                        unseen = unseenOf(after);
  d.error_unit = "noise2";
  const Eigen::MatrixXd of_noise = noiseSquares(*posteriorWith(problem_, {}, split_.judging.motions));
  d.noise_floor = meanSquare(of_noise);
  d.samples = split_.selecting.motions.size() + split_.judging.motions.size();
  d.effective_samples = static_cast<double>(d.samples);
  d.baseline = {meanSquare(seen_before), meanSquare(before)};
  d.extended = {meanSquare(seen_after), meanSquare(unseen)};
  const Eigen::ArrayXd all_of_it = Eigen::ArrayXd::Zero(before.cols());
  d.explained_percent = 100.0 * explainedShare(before, unseen, all_of_it);
  d.explainable_percent = std::max(d.explained_percent, 100.0 * explainedShare(before, of_noise, all_of_it));
  Eigen::MatrixXd all_before(before.rows(), seen_before.cols() + before.cols()), all_after = all_before;
  all_before << seen_before, before;
  all_after << seen_after, unseen;
  // The right causes leave the discrepancy, too.
  explained_of_all_ = 100.0 * explainedShare(all_before, all_after, Eigen::ArrayXd::Ones(all_before.cols()));
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
                                 worstMoment(set.motions[m], played[m], result_.layout, after.posterior().noise())});
    }
  };
  say(split_.selecting, false, seen_before, seen_after, selected);
  say(split_.judging, true, before, unseen, result_.after);
  fillUnexplained(after, seen_after, unseen);
}

/// Drives that saturate leave more in the currents than a model does; joints and shafts show what is missing.
void MotionDiagnosing::fillUnexplained(const MotionCauseFit& after, const Eigen::MatrixXd& seen,
                                       const Eigen::MatrixXd& unseen) {
  Diagnosis& d = result_.diagnosis;
  const Eigen::VectorXd missed = unseen.topRows(unseen.rows() - 1).rowwise().mean(), fitted = seen.rowwise().mean();
  if (std::ranges::none_of(missed, [](double left) { return isLeft(left, 0.0, 0.0); })) return;
  const Eigen::VectorXd unknown = unknownSquares(after, problem_, split_.judging.motions);
  for (Eigen::Index g = 0; g < missed.size(); ++g) {
    const double left = missed[g];
    // A cause's law is no exact one: what it leaves in fitted motions denies nothing.
    if (!isLeft(left, last_ ? 0.0 : fitted[g], unknown[g])) continue;
    const std::string name = g + 2 < unseen.rows() ? "joint " + result_.layout.joints[g].name : std::string("shafts");
    const double share = (left - 1.0) / static_cast<double>(unseen.rows()) / d.baseline.mse_heldout;
    d.unexplained.push_back({name, share, ""});
    d.left_over_percent += 100.0 * share;
  }
}

void MotionDiagnosing::sayWhatIsLeft() {
  Diagnosis& d = result_.diagnosis;
  const auto worst = std::ranges::max_element(
      result_.motions, {}, [](const MotionSay& say) { return std::isfinite(say.after) ? say.after : kInfinity; });
  std::vector<std::string> channels;
  for (const Leftover& left : d.unexplained) channels.push_back(left.channel);
  d.sentence = fmt::format("missed by more than noise leaves: {}; no cause that was fitted explains it. Worst: {}, {}",
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
  const bool promising =
      std::ranges::any_of(d.candidates, [](const Candidate& c) { return c.gain_heldout.lower95 > 0.0; });
  if (promising && !instead) return;
  shift_ = furthestShift(*plain_);
  if (!shift_) return;
  const Eigen::MatrixXd before = unseenSquares(*plain_, shift_->back, problem_, split_.judging.motions);
  const Interval gain = gainOf(logGains(before, unseenOf(*plain_)));
  if (!(gain.lower95 > 0.0) || gain.value < kLeastMotionGain) return;
  const double times_noise = d.extended.mse_heldout / d.noise_floor;
  if (times_noise > kNothingElse) {
    d.candidates.push_back({shift_->cause.effect, shift_->cause.target,
                            fmt::format("beside it held-out motions are missed by {:.1f} times the noise's mean "
                                        "square: it may stand for what is missing there",
                                        times_noise),
                            gain});
    return;
  }
  shift_->cause.gain_heldout = gain;
  d.causes.push_back(shift_->cause);
  d.explained_percent = 100.0 * gain.value;
  d.explainable_percent = std::max(d.explained_percent, 100.0 * (1.0 - d.noise_floor / meanSquare(before)));
  compareWithExpected(before);
}

/// The model without the cause has the parameter as it was expected. \param judging  squares of held-out motions then
void MotionDiagnosing::compareWithExpected(const Eigen::MatrixXd& judging) {
  const Eigen::MatrixXd selecting = unseenSquares(*plain_, shift_->back, problem_, split_.selecting.motions);
  result_.diagnosis.baseline = {meanSquare(selecting), meanSquare(judging)};
  result_.baseline = plain_->posterior().modelAt(shift_->back);
  result_.before = playAll(result_.baseline, split_.judging.motions, problem_.options.motion,
                           plain_->posterior().captureDelay(shift_->back));
  for (Eigen::Index m = 0; m < selecting.cols() + judging.cols(); ++m) {
    const bool held_out = m >= selecting.cols();
    const Eigen::MatrixXd& squares = held_out ? judging : selecting;
    result_.motions[m].before = squares.col(held_out ? m - selecting.cols() : m).mean();
    result_.motions[m].evidence = std::nan("");  // no fit was made without it
  }
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
    fillParameters(d, split_.selecting, problem_.options.motion.rollout.step);
    d.causes.front().absorbed_by = shiftsBetween(*plain_, *last_);
  }
  keepCandidates();
  d.evidence = errorsOverTime(split_.judging, result_.before, result_.after, result_.layout);
  d.verdict = verdictOf(d.causes, !d.unexplained.empty());
  if (!d.causes.empty()) {
    const Cause& first = d.causes.front();
    std::vector<std::string> group = first.ambiguous_with;
    group.insert(group.begin(), effectLabel(first.effect, first.target));
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
  if (shift_ && !d.causes.empty()) return;  // it is named
  const MotionCauseFit& fit = last_ ? *last_ : *plain_;
  const MotionPosterior& posterior = fit.posterior();
  std::ranges::move(farParameters(posterior.parameters(), posterior.space(), fit.here().z, fit.ordinary()),
                    std::back_inserter(d.warnings));
}

}  // namespace simgap
