#include "motion_selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <span>

#include "diagnose/surrogates.h"

namespace simgap {
namespace {

constexpr int kPlainRounds = 3;     // of derivatives made anew
constexpr int kRefreshRounds = 4;   // of it, from a better place, or where little is promised
constexpr double kOnItsWay = 0.1;   // of what is promised, that its last round gained
constexpr std::size_t kRefits = 6;  // with derivatives of the model without the cause
constexpr std::size_t kOfOneEffect = 2;
constexpr double kLeavesMuch = 2.0;  // noise variances that the best leaves
constexpr int kMoreWaves = 2, kOwedOfMore = 3;
constexpr std::size_t kTold = 5;        // hypotheses that a report lists where none was fitted
constexpr double kHopelessGain = 3.0;   // promised by the scan [negative log posterior]
constexpr std::size_t kOthersKept = 4;  // that a change of the arm may still prove, besides rivals
constexpr double kSteady = 2.0;         // and standard errors over motions
constexpr double kGained = 0.5, kGainedShare = 3e-4;

/// Whether motions tell two fits apart: by how much, and whether most of them say so.
bool toldApart(const MotionCauseFit& better, const MotionCauseFit& worse, double variance) {
  if ((worse.objective() - better.objective()) / variance < kMotionsTellApart) return false;
  const Eigen::ArrayXd lead = worse.losses() - better.losses();
  const double count = static_cast<double>(lead.size());
  const double error = std::sqrt((lead - lead.mean()).square().sum() / (count * std::max(1.0, count - 1.0)));
  // Where one motion says far more than all others the mean is as uncertain as it is large; then they are counted.
  constexpr double kMostMotions = 0.75;
  const double say_so = static_cast<double>((lead / variance > kMotionsTellApart / count).count());
  return lead.mean() > kSteady * error || say_so >= kMostMotions * count;
}

/// Motions that do not tell which of two muscles a cause is of do not exclude that it is of all.
void nameOfAll(const ArmCause& cause, std::vector<std::string>& rivals) {
  const std::string all(cause.effect->name);
  const bool of_another =
      std::ranges::any_of(rivals, [&](const std::string& rival) { return rival.starts_with(all + ":"); });
  const bool of_one = cause.effect->target == ArmEffect::Target::kMuscleOrAll && !cause.target.empty();
  if (of_one && of_another && std::ranges::find(rivals, all) == rivals.end()) rivals.push_back(all);
}

MotionPlan planOf(const MotionProblem& problem, const std::vector<ArmHypothesis>& hypotheses) {
  const auto single = static_cast<std::size_t>(std::ranges::count_if(hypotheses, ofOneMuscle));
  const std::size_t parameters = ParameterSpace(problem.nominal, problem.parameters).size() + 1;
  return {parameters, problem.motions.size(), single, hypotheses.size() - single};
}

}  // namespace

bool MotionSelector::enough(double gain, double objective) {
  return gain < std::max(kGained, kGainedShare * objective);
}

MotionSelector::MotionSelector(const MotionProblem& problem, const std::vector<ArmHypothesis>& hypotheses,
                               std::uint64_t seed, double level, News news)
    : problem_(problem),
      hypotheses_(hypotheses),
      seed_(seed),
      level_(level),
      news_(std::move(news)),
      plan_(planOf(problem, hypotheses)) {}

MotionCauseFit::News MotionSelector::newsOf() {
  return [this](long rollouts) { tell(rollouts_ + rollouts); };
}

void MotionSelector::tell(long rollouts) {
  if (news_) news_(plan_.done(rollouts));
}

void MotionSelector::count(long rollouts) {
  rollouts_ += rollouts;
  tell(rollouts_);
}

void MotionSelector::converge(MotionCauseFit& fit, int most) {
  for (int round = 1; round <= most; ++round) {
    gained_ = fit.refresh(newsOf());
    if (enough(gained_, fit.objective())) return;
  }
}

std::unique_ptr<MotionCauseFit> MotionSelector::fitPlain() {
  auto fit = std::make_unique<MotionCauseFit>(problem_, std::vector<ArmCause>{});
  fit->begin(newsOf());
  first_ = fit->here();
  fit->descend();
  converge(*fit, kPlainRounds);
  count(fit->rollouts());
  return fit;
}

/// The trials that are worth a fit, the best first. Beside one of a single muscle stands the same effect of all
/// muscles, whatever the scan says: where the fit without it is far off, one muscle alone may promise more than all of
/// them, and would be named for what all do.
std::vector<const MotionTrial*> MotionSelector::worthFitting(const MotionScan& scan,
                                                             const std::vector<ArmHypothesis>& open,
                                                             const std::vector<Refit>& fitted) {
  std::vector<const MotionTrial*> chosen;
  const auto isFitted = [&](const MotionTrial& trial) {
    return std::ranges::any_of(fitted, [&](const Refit& refit) { return open[trial.hypothesis].isOf(refit.cause()); });
  };
  const auto add = [&](const MotionTrial& trial) {
    if (std::ranges::find(chosen, &trial) == chosen.end() && !isFitted(trial)) chosen.push_back(&trial);
  };
  std::map<const ArmEffect*, std::size_t> of_effect;
  for (const MotionTrial& trial : scan.trials) {
    if (chosen.size() >= kRefits || trial.gain < kHopelessGain) break;
    const ArmHypothesis& hypothesis = open[trial.hypothesis];
    if (isFitted(trial)) continue;
    if (!hypothesis.target.empty() && ++of_effect[hypothesis.effect] > kOfOneEffect) continue;
    add(trial);
    const auto of_all = std::ranges::find_if(scan.trials, [&](const MotionTrial& other) {
      return open[other.hypothesis].effect == hypothesis.effect && open[other.hypothesis].target.empty();
    });
    if (of_all != scan.trials.end()) add(*of_all);
  }
  return chosen;
}

/// The effect of the best of those fitted on other muscles: a scan from where the model is lost tells these apart
/// badly.
std::vector<const MotionTrial*> MotionSelector::otherTargets(const MotionScan& scan,
                                                             const std::vector<ArmHypothesis>& open,
                                                             const std::vector<Refit>& fitted) {
  std::vector<const MotionTrial*> chosen;
  for (const MotionTrial& trial : scan.trials) {
    const ArmHypothesis& one = open[trial.hypothesis];
    const bool known = std::ranges::any_of(fitted, [&](const Refit& refit) { return one.isOf(refit.cause()); });
    if (one.effect == fitted.front().cause().effect && !known && chosen.size() < kRefits) chosen.push_back(&trial);
  }
  return chosen;
}

/// What looks like the best and is still on its way may pass it yet.
bool MotionSelector::Refit::mayPass(const Refit& best) const {
  return looksLike({cause().effect, cause().target, {}}, best.cause()) && !settled &&
         fit->objective() - best.fit->objective() < kOnTheWay * gained;
}

/// Of the best's effect on all muscles, or what looks like it.
bool MotionSelector::Refit::standsBeside(const ArmCause& best) const {
  return cause().effect == best.effect ? cause().target.empty() : looksLike({cause().effect, cause().target, {}}, best);
}

/// A fit that has begun and descended with the derivatives at hand; null where the motions cannot be played there.
std::unique_ptr<MotionCauseFit> MotionSelector::descended(std::vector<ArmCause> causes, const Begin& begin) {
  auto fit = std::make_unique<MotionCauseFit>(problem_, std::move(causes));
  const bool begun = begin(*fit);
  if (begun) fit->descend();
  count(fit->rollouts());
  return begun ? std::move(fit) : nullptr;
}

/// Fits of the causes that the scan likes best, from where the model without them ended and from the prior's mean.
std::vector<MotionSelector::Refit> MotionSelector::refit(const MotionCauseFit& base,
                                                         std::span<const MotionPoint> points,
                                                         const std::vector<ArmHypothesis>& open,
                                                         const std::vector<const MotionTrial*>& chosen) {
  std::vector<Refit> refits;
  for (const MotionTrial* trial : chosen) {
    const ArmHypothesis& hypothesis = open[trial->hypothesis];
    const std::vector<ArmCause> causes =
        withOneMore(base.causes(), {hypothesis.effect, hypothesis.target, trial->start});
    std::unique_ptr<MotionCauseFit> best;
    for (const MotionPoint& point : points) {
      auto fit = descended(causes, [&](MotionCauseFit& one) { return one.beginBeside(point); });
      if (fit && (!best || fit->objective() < best->objective())) best = std::move(fit);
    }
    if (!best) continue;
    const long before = best->rollouts();
    best->descend();
    count(best->rollouts() - before);
    refits.push_back({std::move(best), trial->gain});
  }
  return refits;
}

/// Scans from where the model without another cause ended, and from the prior's mean while it has none.
/// \param[out] points  these places
MotionScan MotionSelector::lookAround(const MotionCauseFit& base, const std::vector<ArmHypothesis>& open,
                                      std::vector<MotionPoint>& points) {
  points.clear();
  points.emplace_back(base.posterior(), base.here());
  if (base.causes().empty()) points.emplace_back(base.posterior(), first_);
  const long before = rollouts_;
  MotionScan scan = scanMotions(points, open, seed_, [&](long rollouts) { tell(before + rollouts); });
  count(scan.rollouts);
  return scan;
}

/// What a fit with a cause gained without it, the model without it may have as well.
void MotionSelector::improveBase(MotionCauseFit& base, const MotionCauseFit& with) {
  const long before = base.rollouts();
  if (base.moveTo(with.withoutLast())) converge(base, kRefreshRounds);
  count(base.rollouts() - before);
}

std::unique_ptr<MotionCauseFit> MotionSelector::without(const MotionCauseFit& fit, std::size_t cause) {
  auto left =
      descended(withoutOne(fit.causes(), cause), [&](MotionCauseFit& one) { return one.beginWithout(fit, cause); });
  if (!left) return left;
  const long before = left->rollouts();
  converge(*left, kRefreshRounds);
  count(left->rollouts() - before);
  return left;
}

/// The best of the fits, with those that motions do not tell from it.
FoundCause MotionSelector::conclude(const MotionCauseFit& base, std::vector<Refit>& refits,
                                    const std::vector<double>& placebos, std::vector<HypothesisRecord>& records) {
  FoundCause found;
  Refit& best = refits.front();
  const double variance = std::max(1.0, best.fit->misfit());
  found.evidence = (base.objective() - best.fit->objective()) / variance;
  found.by_motion = (base.losses() - best.fit->losses()) / variance;
  // Placebos are granted one step of a scan. Where that one was lost its promise says little, and what a fit then gains
  // many times over no placebo's step does; held-out motions judge it besides.
  constexpr double kBeyondAStep = 10.0;
  found.p = placeboP(std::max(best.promised, found.evidence / kBeyondAStep), placebos);
  for (const Refit& one : refits) {
    const ArmCause& cause = one.cause();
    const double odds = (base.objective() - one.fit->objective()) / variance;
    const bool rival = &one != &best && (one.mayPass(best) || !toldApart(*best.fit, *one.fit, variance));
    if (rival) found.rivals.push_back(cause.label());
    records.push_back({base.causes().size() + 1, std::string(cause.effect->name), cause.target, kNotMeasured,
                       &one == &best ? found.p : 1.0,
                       &one == &best ? "best"
                       : rival       ? "ambiguous"
                                     : fmt::format("rejected: {:.1f} behind the best", found.evidence - odds),
                       odds});
    if (&one != &best && (rival || found.others.size() < kOthersKept)) {
      found.others.push_back(candidateOf(*one.fit, "instead"));
    }
  }
  nameOfAll(best.cause(), found.rivals);
  found.fit = std::move(best.fit);
  return found;
}

std::optional<FoundCause> MotionSelector::step(MotionCauseFit& base, std::vector<HypothesisRecord>& records) {
  std::vector<ArmHypothesis> open = hypotheses_;
  std::erase_if(open, [&](const ArmHypothesis& hypothesis) {
    return std::ranges::any_of(base.causes(), [&](const ArmCause& cause) { return cause.effect == hypothesis.effect; });
  });
  if (open.empty()) return std::nullopt;
  if (!base.causes().empty()) gained_ = 0.0;  // it was fitted until nothing was gained
  std::vector<MotionPoint> points;
  plan_.begin(MotionPlan::kScan, rollouts_);
  MotionScan scan = lookAround(base, open, points);
  if (scan.trials.empty() || gained_ > kOnItsWay * scan.trials.front().gain) {
    // What is promised may be the model's own, which is still on its way.
    const long before = base.rollouts();
    converge(base, kRefreshRounds);
    count(base.rollouts() - before);
    scan = lookAround(base, open, points);
  }
  if (scan.trials.empty() || placeboP(scan.trials.front().gain, scan.placebos) > level_) {
    // However well it fits, none could be named.
    for (const MotionTrial& trial : std::span(scan.trials).first(std::min(kTold, scan.trials.size()))) {
      const ArmHypothesis& one = open[trial.hypothesis];
      records.push_back({base.causes().size() + 1, std::string(one.effect->name), one.target, kNotMeasured,
                         placeboP(trial.gain, scan.placebos), "rejected: promises no more than its placebos",
                         trial.gain});
    }
    return std::nullopt;
  }
  plan_.begin(MotionPlan::kFits, rollouts_);
  std::vector<Refit> refits = refit(base, points, open, worthFitting(scan, open, {}));
  if (refits.empty()) return std::nullopt;
  plan_.begin(MotionPlan::kDerivatives, rollouts_);
  settle(base, open, refits, 0);
  for (int wave = 0; wave <= kMoreWaves && refits.front().fit->misfit() > kLeavesMuch; ++wave) {
    // What the scan liked less: it looked from where the model without the cause was lost.
    std::vector<Refit> more = refit(
        base, points, open, wave < kMoreWaves ? worthFitting(scan, open, refits) : otherTargets(scan, open, refits));
    if (more.empty()) continue;
    std::ranges::move(more, std::back_inserter(refits));
    settle(base, open, refits, kOwedOfMore);
  }
  points.clear();
  finishRivals(refits);
  improveBase(base, *refits.front().fit);
  return conclude(base, refits, scan.placebos, records);
}

}  // namespace simgap
