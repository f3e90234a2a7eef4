#include "pose_selection.h"

#include <fmt/format.h>

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <deque>
#include <numeric>
#include <span>

#include "compared.h"
#include "diagnose/paired_error.h"
#include "impossible_sizes.h"
#include "pose_candidates.h"
#include "pose_evidence.h"
#include "pose_score.h"
#include "pose_validation.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/poses/levenberg_marquardt.h"
#include "stray_friction.h"

namespace simgap {
namespace {

constexpr double kClearOdds = 1.0;      // log odds that a cause must reach
constexpr double kSureOdds = 3.0;       // from which a small gain on unseen poses is enough, as long as it may be one
constexpr double kTellApart = 3.5;      // log odds between two causes below which the poses do not tell them apart
constexpr double kSmallestGain = 0.01;  // of the error on poses a fit has not seen
constexpr double kTryTolerance = 3e-5;  // of the objective, some 0.01: far below what decides
constexpr double kHopelessPoseCause =
    30.0;                             // log odds behind a step's best, beyond which no exchange will bring a rival back
constexpr double kSameMinimum = 0.3;  // objectives nearer than this belong to one minimum
constexpr int kBetterBases = 3;
constexpr std::size_t kFewPoses = 30;
constexpr double kMostPosesLeftOut = 0.1;  // of the poses: where more have no rest, the model is wrong, not the poses
constexpr std::size_t kKept = 3;           // models of other causes that are kept beside each
constexpr std::size_t kTried = 6;          // candidates of a step that are cross-validated until one passes

class PoseSelector {
 public:
  PoseSelector(const PoseProblem& problem, std::span<const Pose> poses, const std::vector<ArmHypothesis>& hypotheses,
               const PoseDiagnosisOptions& options)
      : problem_(problem), poses_(poses), hypotheses_(hypotheses), options_(options), folds_(poses) {}

  PoseSelection run(const Eigen::VectorXd& start, const std::function<void(std::string_view)>& stage);

 private:
  PoseFit refit(const std::vector<ArmCause>& causes, PoseFit& like, const Eigen::VectorXd& z,
                double tolerance = 1e-7) const;
  PoseFit settled(const std::vector<ArmCause>& causes, const Eigen::VectorXd& z) {
    return settledFit(problem_, poses_, causes, z);
  }
  std::vector<ArmHypothesis> openBeside(const std::vector<ArmCause>& causes) const;
  std::vector<PoseCandidate> tryAll(PoseFit& fit, const std::vector<ArmHypothesis>& hypotheses) const;
  void lookAgain(PoseFit& fit, std::vector<PoseCandidate>& candidates) const;
  void lookFromHere(const PoseFit& fit, PoseFit& without, std::vector<PoseCandidate>& candidates) const;
  bool improveBase(PoseFit& fit, const PoseCandidate& candidate) const;
  double pAdjusted(const PoseCandidate& candidate) const;
  std::string objection(const PoseFit& fit, const PoseCandidate& candidate, const CrossValidation& before, double odds,
                        Interval& gain) const;
  bool step(PoseFit& fit, PoseSelection& selection);
  void leaveOut(PoseFit& fit, PoseSelection& selection);
  void exchange(PoseFit& fit, PoseSelection& selection);
  void prune(PoseFit& fit, PoseSelection& selection);
  std::string impossibleWith(const PoseFit& fit, const PoseCandidate& candidate) const;
  void dropImpossible(PoseFit& fit, PoseSelection& selection);
  void takeOut(std::size_t cause, std::string outcome, PoseFit& fit, PoseSelection& selection);

  PoseProblem problem_;  ///< with the stray friction of the fit that others are compared with
  std::span<const Pose> poses_;
  std::vector<ArmHypothesis> hypotheses_;
  const PoseDiagnosisOptions& options_;
  PoseFolds folds_;
  std::deque<std::vector<Pose>> kept_;  ///< what poses_ is without those left out; fits hold spans of all of them
};

PoseFit PoseSelector::refit(const std::vector<ArmCause>& causes, PoseFit& like, const Eigen::VectorXd& z,
                            double tolerance) const {
  PoseFit fit(problem_, poses_, causes);
  fit.posterior().whitenLike(like.posterior());
  fit.descend(fit.extended(z), tolerance);
  return fit;
}

std::vector<ArmHypothesis> PoseSelector::openBeside(const std::vector<ArmCause>& causes) const {
  std::vector<ArmHypothesis> open;
  for (const ArmHypothesis& h : hypotheses_) {
    if (std::ranges::none_of(causes, [&](const ArmCause& cause) { return h.isOf(cause); })) open.push_back(h);
  }
  return open;
}

/// Every hypothesis beside the causes of `fit`, each with all its starts; the best start of each.
std::vector<PoseCandidate> PoseSelector::tryAll(PoseFit& fit, const std::vector<ArmHypothesis>& hypotheses) const {
  struct Try {
    std::size_t hypothesis;
    ArmCause cause;
    PoseCandidate result;
  };
  std::vector<Try> tries;
  for (std::size_t h = 0; h < hypotheses.size(); ++h) {
    for (const EffectParameters& start : hypotheses[h].starts) {
      tries.push_back({h, {hypotheses[h].effect, hypotheses[h].target, start}, {}});
    }
  }
  const Compared plain(fit);
  const auto tryThis = [&](std::size_t t) {
    PoseFit more = refit(withOneMore(fit.causes(), tries[t].cause), fit, fit.z(), kTryTolerance);
    return Compared::pack(more);
  };
  forEachOnRanks(problem_, tries.size(), fit.z(), tryThis, [&](std::size_t t, const Eigen::VectorXd& found) {
    if (found.size() == 0) return;  // interrupted
    tries[t].result =
        plain.candidate(tries[t].cause, found, shareOf(hypotheses[tries[t].hypothesis], hypotheses_, poses_.size()));
  });
  std::vector<PoseCandidate> best(hypotheses.size());
  for (PoseCandidate& candidate : best) candidate.odds = -std::numeric_limits<double>::infinity();
  for (const Try& one : tries) {
    if (one.result.odds > best[one.hypothesis].odds) best[one.hypothesis] = one.result;
  }
  std::erase_if(best, [](const PoseCandidate& candidate) { return std::isinf(candidate.odds); });
  std::ranges::stable_sort(best, std::greater<>(), &PoseCandidate::odds);
  return best;
}

/// The first few once more, from where the torques at the measured poses balance: a descent that may lose no pose's
/// rest on its way can be held up far from a minimum.
void PoseSelector::lookAgain(PoseFit& fit, std::vector<PoseCandidate>& candidates) const {
  const Compared plain(fit);
  const auto again = [&](std::size_t c) {
    PoseFit more(problem_, poses_, withOneMore(fit.causes(), candidates[c].cause));
    more.posterior().whitenLike(fit.posterior());
    PosePosterior balancing = more.posterior();  // which changes the whitening
    more.descend(balanceTorques(balancing, candidates[c].z), kTryTolerance);
    return Compared::pack(more);
  };
  const std::size_t count = std::min(kTried, candidates.size());
  forEachOnRanks(problem_, count, fit.z(), again, [&](std::size_t c, const Eigen::VectorXd& found) {
    if (found.size() == 0) return;  // interrupted
    PoseCandidate other = plain.candidate(candidates[c].cause, found, candidates[c].share);
    if (other.odds > candidates[c].odds) candidates[c] = std::move(other);
  });
  std::ranges::stable_sort(candidates, std::greater<>(), &PoseCandidate::odds);
}

double PoseSelector::pAdjusted(const PoseCandidate& candidate) const {
  const auto freedom = static_cast<int>(fittedParameters(*candidate.cause.effect));
  return std::min(1.0, chiSquaredTail(2.0 * candidate.likelihood, freedom) / candidate.share);
}

/// A hypothesis may have found the way out of a local minimum that had nothing to do with it: then the model without it
/// goes there too. \returns whether that was better
bool PoseSelector::improveBase(PoseFit& fit, const PoseCandidate& candidate) const {
  PoseFit other = refit(fit.causes(), fit, candidate.z.head(fit.z().size()));
  if (!(other.objective() < fit.objective() - kSameMinimum)) return false;
  fit = std::move(other);
  return true;
}

/// Why a candidate cannot be, with the sizes that fitted best.
std::string PoseSelector::impossibleWith(const PoseFit& fit, const PoseCandidate& candidate) const {
  PoseFit with(problem_, poses_, withOneMore(fit.causes(), candidate.cause));
  with.setSolution(candidate.z);
  return impossibleSize(with, fit.causes().size());
}

/// Why a candidate that the evidence speaks for is not accepted: poses that its fits have not seen. \returns empty when
/// it is
std::string PoseSelector::objection(const PoseFit& fit, const PoseCandidate& candidate, const CrossValidation& before,
                                    double odds, Interval& gain) const {
  const std::vector<ArmCause> causes = withOneMore(fit.causes(), candidate.cause);
  const CrossValidation after = folds_.validate(problem_, causes, candidate.z, fit.causes(), fit.z());
  gain = pairedGain(before.distances, after.distances, options_.seed);
  // Few poses let a wrong cause look good by absorbing what the priors do not: then it has to be clear of chance.
  // Beside an accepted cause, what only may be a gain is not one: a look-alike takes up what the first has left over.
  const bool first = fit.causes().empty();
  const double surest = poses_.size() < kFewPoses    ? gain.lower95
                        : odds < kSureOdds || !first ? gain.value
                                                     : gain.upper95;
  return surest < kSmallestGain ? "no sure gain on poses that its fits have not seen" : "";
}

/// One forward step. \returns whether a cause was accepted
bool PoseSelector::step(PoseFit& fit, PoseSelection& selection) {
  std::vector<ArmHypothesis> open = openBeside(fit.causes());
  placeMoments(problem_, fit, open);
  std::vector<PoseCandidate> candidates = tryAll(fit, open);
  lookAgain(fit, candidates);
  for (int round = 0; round < kBetterBases && !candidates.empty() && improveBase(fit, candidates.front()); ++round) {
    candidates = tryAll(fit, open);
    lookAgain(fit, candidates);
  }
  if (fit.causes().empty()) {
    selection.z_plain = fit.z();
    selection.stray_plain = problem_.stray_friction;
  }
  const std::size_t number = selection.causes.size() + 1;
  const CrossValidation before = folds_.validate(problem_, fit.causes(), fit.z(), fit.causes(), fit.z());
  const PoseCandidate* accepted = nullptr;
  selection.candidates.clear();
  std::size_t tried = 0;
  for (const PoseCandidate& candidate : candidates) {
    const double odds = candidate.odds;
    HypothesisRecord record{
        number, std::string(candidate.cause.effect->name), candidate.cause.target, kNotMeasured, 1.0, "", odds};
    record.p_adjusted = pAdjusted(candidate);
    if (odds < kClearOdds || record.p_adjusted > options_.level) {
      record.outcome = fmt::format("rejected: log odds {:.1f}", odds);
    } else if (accepted || tried == kTried) {
      record.outcome = "passed over";
    } else {
      std::string why = impossibleWith(fit, candidate);
      const bool impossible = !why.empty();
      // The best is there, but not as what it says: whatever comes next would stand in for it.
      selection.tethered = impossible && candidate.cause.effect->gravity != nullptr;
      tried = selection.tethered ? kTried : tried + 1;
      if (!impossible) why = objection(fit, candidate, before, odds, record.gain_inner);
      if (!why.empty()) {
        record.outcome = "rejected: " + why;
        if (impossible || odds >= kSureOdds)
          selection.candidates.push_back({record.effect, record.target, why, kNotMeasured});
      } else {
        record.outcome = fmt::format("accepted: log odds {:.1f}", odds);
        accepted = &candidate;
        AcceptedCause cause{candidate.cause, odds, record.p_adjusted, record.gain_inner, {}, {}};
        for (const PoseCandidate& other : candidates) {
          if (other.odds > candidate.odds - kHopelessPoseCause) cause.contenders.insert(other.cause.label());
        }
        selection.causes.push_back(std::move(cause));
      }
    }
    selection.records.push_back(std::move(record));
  }
  if (!accepted) {
    for (std::size_t i = 0; i < std::min(kKept, candidates.size()); ++i)
      selection.refused.push_back(candidates[i].cause);
    return false;
  }
  fit = settled(withOneMore(fit.causes(), accepted->cause), accepted->z);
  leaveOut(fit, selection);
  return true;
}

/// A pose near which the model with the causes has no rest holds the fit back, as no step may lose the last rest it has
/// far away; a further cause that gives it one looks as if the poses spoke for it.
void PoseSelector::leaveOut(PoseFit& fit, PoseSelection& selection) {
  const std::vector<bool> without = posesWithoutRest(fit, poses_);
  const auto lost = static_cast<std::size_t>(std::ranges::count(without, true));
  if (lost == 0 || static_cast<double>(lost) > kMostPosesLeftOut * static_cast<double>(poses_.size())) return;
  std::vector<Pose>& kept = kept_.emplace_back();
  for (std::size_t p = 0; p < poses_.size(); ++p) {
    if (without[p]) {
      selection.left_out.push_back(poses_[p].name);
    } else {
      kept.push_back(poses_[p]);
    }
  }
  poses_ = kept;
  folds_ = PoseFolds(poses_);
  fit = settled(fit.causes(), fit.z());
}

/// The first cause of `fit` among the candidates for its place, from where it is: its usual start may not find that way
/// again beside what came after it.
void PoseSelector::lookFromHere(const PoseFit& fit, PoseFit& without, std::vector<PoseCandidate>& candidates) const {
  const ArmCause& present = fit.causes().front();
  const auto found = std::ranges::find(candidates, present.label(), [](const auto& c) { return c.cause.label(); });
  if (found == candidates.end()) return;
  const Eigen::VectorXd rest = fit.solutionWithout(0);
  Eigen::VectorXd z(fit.z().size());
  z << rest, fit.z().segment(static_cast<Eigen::Index>(fit.ordinary()), z.size() - rest.size());
  PoseFit from_here = refit(withOneMore(without.causes(), present), without, z, kTryTolerance);
  PoseCandidate here = Compared(without).candidate(present, Compared::pack(from_here), found->share);
  if (here.odds > found->odds) *found = std::move(here);
  std::ranges::stable_sort(candidates, std::greater<>(), &PoseCandidate::odds);
}

/// Each cause against all rivals in its place, with the other causes there: the best stays, those near it are listed.
/// A cause that was tried goes to the end of the line, so that all stand in their order again when each has been.
void PoseSelector::exchange(PoseFit& fit, PoseSelection& selection) {
  for (std::size_t turn = selection.causes.size(); turn > 0; --turn) {
    AcceptedCause cause = selection.causes.front();
    selection.causes.erase(selection.causes.begin());
    std::vector<ArmCause> causes = withoutOne(fit.causes(), 0);
    PoseFit without = refit(causes, fit, fit.solutionWithout(0));
    std::vector<ArmHypothesis> open = openBeside(causes);
    std::erase_if(open, [&](const ArmHypothesis& h) { return !cause.contenders.contains(h.label()); });
    placeMoments(problem_, without, open);
    std::vector<PoseCandidate> candidates = tryAll(without, open);
    lookFromHere(fit, without, candidates);
    std::erase_if(candidates, [&](const PoseCandidate& c) { return !impossibleWith(without, c).empty(); });
    if (candidates.empty()) {
      selection.causes.push_back(cause);
      causes.push_back(cause.cause);
      fit = refit(causes, fit, without.z());
      continue;
    }
    const PoseCandidate& best = candidates.front();
    if (best.cause.label() != cause.cause.label()) {
      selection.records.push_back({selection.causes.size() + 2, std::string(cause.cause.effect->name),
                                   cause.cause.target, kNotMeasured, 1.0, "exchanged for " + best.cause.label()});
    }
    cause.cause = best.cause;
    cause.odds = best.odds;
    cause.p_adjusted = pAdjusted(best);
    cause.rivals.clear();
    cause.instead.clear();
    for (const PoseCandidate& other : std::span(candidates).subspan(1)) {
      const bool rival = best.odds - other.odds < kTellApart;
      if (rival) cause.rivals.push_back(other.cause.label());
      if (rival || cause.instead.size() < kKept) cause.instead.push_back(other.cause);
    }
    selection.causes.push_back(cause);
    causes.push_back(best.cause);
    fit = settled(causes, best.z);
  }
}

void PoseSelector::takeOut(std::size_t cause, std::string outcome, PoseFit& fit, PoseSelection& selection) {
  const ArmCause& gone = selection.causes[cause].cause;
  selection.records.push_back({selection.causes.size() + 1, std::string(gone.effect->name), gone.target, kNotMeasured,
                               1.0, std::move(outcome)});
  selection.causes.erase(selection.causes.begin() + static_cast<std::ptrdiff_t>(cause));
  fit = settled(withoutOne(fit.causes(), cause), fit.solutionWithout(cause));
}

/// Removes causes that the later ones have made needless.
void PoseSelector::prune(PoseFit& fit, PoseSelection& selection) {
  for (std::size_t c = selection.causes.size(); c-- > 0 && selection.causes.size() > 1;) {
    if (selection.causes[c].odds < kClearOdds) takeOut(c, "pruned", fit, selection);
  }
}

/// Removes causes whose sizes cannot be beside the others.
void PoseSelector::dropImpossible(PoseFit& fit, PoseSelection& selection) {
  for (std::size_t c = selection.causes.size(); c-- > 0;) {
    const std::string why = impossibleSize(fit, c);
    if (why.empty()) continue;
    const ArmCause& cause = selection.causes[c].cause;
    selection.candidates.push_back({std::string(cause.effect->name), cause.target, why, kNotMeasured});
    takeOut(c, "rejected: " + why, fit, selection);
  }
}

PoseSelection PoseSelector::run(const Eigen::VectorXd& start, const std::function<void(std::string_view)>& stage) {
  PoseSelection selection;
  PoseFit fit = settled({}, start);
  do {
    stage(fmt::format("step {}", selection.causes.size() + 1));
  } while (step(fit, selection) && selection.causes.size() < options_.max_causes);
  stage("rivals");
  exchange(fit, selection);
  prune(fit, selection);
  dropImpossible(fit, selection);
  dropNamedRivals(selection);
  selection.z = fit.z();
  selection.stray = problem_.stray_friction;
  const CrossValidation last = folds_.validate(problem_, fit.causes(), fit.z(), fit.causes(), fit.z());
  const auto excess = [](const CrossValidation& result) {
    return std::accumulate(result.distances.begin(), result.distances.end(), 0.0) / result.expected - 1.0;
  };
  selection.excess = excess(last);
  problem_.stray_friction = selection.stray_plain;
  selection.excess_plain = excess(folds_.validate(problem_, {}, selection.z_plain, {}, selection.z_plain));
  selection.excess_sd = std::sqrt(2.0 / last.expected);
  return selection;
}

}  // namespace

PoseSelection selectCauses(const PoseProblem& problem, std::span<const Pose> poses,
                           const std::vector<ArmHypothesis>& hypotheses, const Eigen::VectorXd& start,
                           const PoseDiagnosisOptions& options, const std::function<void(std::string_view)>& stage) {
  return PoseSelector(problem, poses, hypotheses, options).run(start, stage);
}

}  // namespace simgap
