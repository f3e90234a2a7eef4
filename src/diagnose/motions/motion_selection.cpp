#include "motion_selection.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <iterator>
#include <map>
#include <span>

namespace simgap {
namespace {

constexpr int kPlainRounds = 3;     // of derivatives made anew
constexpr int kRefreshRounds = 4;   // of it, from a better place, or where little is promised
constexpr double kOnItsWay = 0.1;   // of what is promised, that its last round gained
constexpr std::size_t kRefits = 6;  // with derivatives of the model without the cause
constexpr std::size_t kOfOneEffect = 2;
constexpr std::array<std::size_t, 5> kRefreshed = {3, 2, 2, 1, 1};  // at most, with derivatives of their own
constexpr std::size_t kMostRounds = 14;                             // the best, and what may still pass it, alone
constexpr double kLeavesMuch = 2.0;                                 // noise variances that the best leaves
constexpr int kMoreWaves = 2, kOwedOfMore = 3;
constexpr double kOfLead = 1e-3;  // of its lead, that a round of the best gains: it need not come to its end
constexpr int kRoundsBack = 8;
constexpr double kOnTheWay = 5.0;          // times what its last derivatives gained: a fit may still come so far
constexpr std::size_t kTold = 5;           // hypotheses that a report lists where none was fitted
constexpr double kHopelessGain = 3.0;      // promised by the scan [negative log posterior]
constexpr double kMotionsTellApart = 6.0;  // evidence by which a cause has to lead
constexpr std::size_t kOthersKept = 4;     // that a change of the arm may still prove, besides rivals
constexpr double kSteady = 2.0;            // and standard errors over motions
constexpr double kGained = 0.5, kGainedShare = 3e-4;  // a round that gains less was the last

bool enough(double gain, double objective) { return gain < std::max(kGained, kGainedShare * objective); }

/// Whether motions tell two fits apart: by how much, and whether most of them say so.
bool toldApart(const MotionCauseFit& better, const MotionCauseFit& worse, double variance) {
  if ((worse.objective() - better.objective()) / variance < kMotionsTellApart) return false;
  const Eigen::ArrayXd lead = worse.losses() - better.losses();
  const double count = static_cast<double>(lead.size());
  const double error = std::sqrt((lead - lead.mean()).square().sum() / (count * std::max(1.0, count - 1.0)));
  return lead.mean() > kSteady * error;
}

/// How often placebos promise as much.
double chanceOf(double promised, const std::vector<double>& placebos) {
  const auto as_good = std::ranges::count_if(placebos, [&](double gain) { return gain >= promised; });
  return (1.0 + static_cast<double>(as_good)) / (1.0 + static_cast<double>(placebos.size()));
}

/// Motions that do not tell which of two muscles a cause is of do not exclude that it is of all.
void nameOfAll(const ArmCause& cause, std::vector<std::string>& rivals) {
  const std::string all(cause.effect->name);
  const bool of_another =
      std::ranges::any_of(rivals, [&](const std::string& rival) { return rival.starts_with(all + ":"); });
  const bool of_one = cause.effect->target == ArmEffect::Target::kMuscleOrAll && !cause.target.empty();
  if (of_one && of_another && std::ranges::find(rivals, all) == rivals.end()) rivals.push_back(all);
}

MotionPlan planOf(const MotionProblem& problem, const std::vector<MotionHypothesis>& hypotheses) {
  const auto single = static_cast<std::size_t>(std::ranges::count_if(hypotheses, ofOneMuscle));
  const std::size_t parameters = ParameterSpace(problem.nominal, problem.parameters).size() + 1;
  return {parameters, problem.motions.size(), single, hypotheses.size() - single};
}

}  // namespace

MotionSelector::MotionSelector(const MotionProblem& problem, const std::vector<MotionHypothesis>& hypotheses,
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
                                                             const std::vector<MotionHypothesis>& open,
                                                             const std::vector<Refit>& fitted) {
  std::vector<const MotionTrial*> chosen;
  const auto isFitted = [&](const MotionTrial& trial) {
    return std::ranges::any_of(fitted, [&](const Refit& refit) { return refit.isOf(open[trial.hypothesis]); });
  };
  const auto add = [&](const MotionTrial& trial) {
    if (std::ranges::find(chosen, &trial) == chosen.end() && !isFitted(trial)) chosen.push_back(&trial);
  };
  std::map<const ArmEffect*, std::size_t> of_effect;
  for (const MotionTrial& trial : scan.trials) {
    if (chosen.size() >= kRefits || trial.gain < kHopelessGain) break;
    const MotionHypothesis& hypothesis = open[trial.hypothesis];
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

bool MotionSelector::Refit::isOf(const MotionHypothesis& hypothesis) const {
  return cause().effect == hypothesis.effect && cause().target == hypothesis.target;
}

/// Of the best's effect on all muscles, or what looks like it.
bool MotionSelector::Refit::standsBeside(const ArmCause& best) const {
  return cause().effect == best.effect ? cause().target.empty() : looksLike({cause().effect, cause().target, {}}, best);
}

/// A fit that has begun and descended with the derivatives at hand; null where the motions cannot be played there.
template <typename Begin>
std::unique_ptr<MotionCauseFit> MotionSelector::descended(std::vector<ArmCause> causes, const Begin& begin) {
  auto fit = std::make_unique<MotionCauseFit>(problem_, std::move(causes));
  const bool begun = begin(*fit);
  if (begun) fit->descend();
  count(fit->rollouts());
  return begun ? std::move(fit) : nullptr;
}

/// Fits of the causes that the scan likes best, from where the model without them ended and from the prior's mean.
std::vector<MotionSelector::Refit> MotionSelector::refit(const MotionCauseFit& base,
                                                         std::span<const MotionPoint> points, const MotionScan& scan,
                                                         const std::vector<MotionHypothesis>& open,
                                                         const std::vector<Refit>& fitted) {
  std::vector<Refit> refits;
  for (const MotionTrial* trial : worthFitting(scan, open, fitted)) {
    const MotionHypothesis& hypothesis = open[trial->hypothesis];
    std::vector<ArmCause> causes = base.causes();
    causes.push_back({hypothesis.effect, hypothesis.target, trial->start});
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

/// The last cause with what is not fitted of it (a speed of creep, a side) as each of the catalogue's starts has it
/// that its target has; its own choice first.
std::vector<std::vector<ArmCause>> MotionSelector::choicesOf(const MotionCauseFit& fit) const {
  std::vector<std::vector<ArmCause>> choices = {fit.causes()};
  const ArmCause chosen = fit.causes().back();
  for (const EffectParameters& start : possibleStarts(*chosen.effect, chosen.target, problem_.nominal)) {
    std::vector<ArmCause> causes = fit.causes();
    for (std::size_t k = 0; k < chosen.effect->parameters.size(); ++k) {
      if (!chosen.effect->parameters[k].fitted) causes.back().start[k] = start[k];
    }
    const auto same = [&](const std::vector<ArmCause>& other) { return other.back().start == causes.back().start; };
    if (std::ranges::none_of(choices, same)) choices.push_back(std::move(causes));
  }
  return choices;
}

/// Another choice where the fit is now: the scan chose it where the model still was without the cause.
void MotionSelector::chooseAgain(Refit& refit) {
  const std::vector<std::vector<ArmCause>> choices = choicesOf(*refit.fit);
  for (const std::vector<ArmCause>& causes : std::span(choices).subspan(1)) {
    auto other = descended(causes, [&](MotionCauseFit& one) { return one.beginAs(*refit.fit, refit.fit->here().z); });
    if (!other || other->objective() >= refit.fit->objective()) continue;
    refit.fit = std::move(other);
    refit.settled = false;
  }
}

/// Ordinary parameters that were driven far from what is expected before the cause had its size may hold the fit in a
/// valley of its own: once more with these as they are expected, with each choice, and with the cause looked for anew
/// (a mass and its distance slide along what their inertia tells). \param least  the objective of the best fit: what
/// will not come so far is given up
void MotionSelector::bringBack(Refit& refit, double least) {
  const std::optional<Eigen::VectorXd> z = refit.fit->withoutFar();
  if (!z && fittedParameters(*refit.cause().effect) < 2) return;
  std::unique_ptr<MotionCauseFit> best;
  const auto keep = [&](std::unique_ptr<MotionCauseFit> other) {
    if (other && (!best || other->objective() < best->objective())) best = std::move(other);
  };
  for (const std::vector<ArmCause>& causes : choicesOf(*refit.fit)) {
    if (z) keep(descended(causes, [&](MotionCauseFit& one) { return one.beginAs(*refit.fit, *z); }));
    keep(descended(causes,
                   [&](MotionCauseFit& one) { return one.beginAnew(*refit.fit, z.value_or(refit.fit->here().z)); }));
  }
  if (!best) return;
  const long before = best->rollouts();
  for (int round = 0; round < kRoundsBack; ++round) {
    const double gained = best->refresh(newsOf());
    if (enough(gained, best->objective()) || best->objective() - least > kOnTheWay * gained) break;
  }
  count(best->rollouts() - before);
  if (best->objective() < refit.fit->objective()) refit.fit = std::move(best);
}

/// What the catalogue says is hard to tell from the best, and the best's own effect on other targets, once more from
/// where that one stands, whether or not the scan liked them: it looked from where the model without a cause was, which
/// may be far from where the ordinary parameters belong.
void MotionSelector::startBesideBest(const MotionCauseFit& base, const std::vector<MotionHypothesis>& open,
                                     std::vector<Refit>& refits) {
  const MotionLinearisation there = refits.front().fit->withoutLastCause();
  const MotionPoint point(base.posterior(), there);
  const ArmCause best = refits.front().cause();
  const double promised = refits.front().promised;
  for (const MotionHypothesis& hypothesis : open) {
    const auto fitted = std::ranges::find_if(refits, [&](const Refit& refit) { return refit.isOf(hypothesis); });
    const bool kin = fitted != refits.end() && hypothesis.effect == best.effect;
    if (fitted == refits.begin() || !(kin || looksLike(hypothesis, best))) continue;
    std::vector<ArmCause> causes = base.causes();
    causes.push_back(fitted == refits.end() ? ArmCause{hypothesis.effect, hypothesis.target, hypothesis.starts.front()}
                                            : fitted->cause());
    auto other = descended(std::move(causes), [&](MotionCauseFit& one) { return one.beginBeside(point); });
    if (!other) continue;
    if (fitted == refits.end()) {
      refits.push_back({std::move(other), promised});
    } else if (other->objective() < fitted->fit->objective()) {
      fitted->fit = std::move(other);
      fitted->promised = std::max(fitted->promised, promised);
    }
  }
}

/// The next best that stands beside the best; refits.size(): none.
std::size_t MotionSelector::owedDerivatives(const std::vector<Refit>& refits) {
  std::size_t i = 1;
  while (i < refits.size() && !refits[i].standsBeside(refits.front().cause())) ++i;
  return i;
}

/// New derivatives for the best and for all that might still pass it, as far as refreshing gained until now: several
/// once, the best of them again. Derivatives of the model without the cause rank badly where it is large; so all
/// muscles' gets its own, however far behind one muscle's it is. \param owed_of_new  so many of those that have none of
/// their own get them
void MotionSelector::settle(const MotionCauseFit& base, const std::vector<MotionHypothesis>& open,
                            std::vector<Refit>& refits, int owed_of_new) {
  const auto byObjective = [](const Refit& a, const Refit& b) { return a.fit->objective() < b.fit->objective(); };
  double most_gained = 0.0;
  bool news = true;
  for (std::size_t round = 0; news && round < kMostRounds; ++round) {
    news = false;
    const std::size_t among = kRefreshed[std::min(round, kRefreshed.size() - 1)];
    std::ranges::stable_sort(refits, byObjective);
    if (!refits.front().settled) chooseAgain(refits.front());
    if (round == 1) startBesideBest(base, open, refits);
    const double best = refits.front().fit->objective(), variance = std::max(1.0, refits.front().fit->misfit());
    const std::size_t owed = round == 0 ? 0 : owedDerivatives(refits);
    for (std::size_t i = 0; i < refits.size(); ++i) {
      MotionCauseFit& fit = *refits[i].fit;
      const double behind = fit.objective() - best;
      const bool far = behind > most_gained + kMotionsTellApart * variance;
      const bool unknown = refits[i].refreshed == 0;
      const bool due = unknown ? i == owed || owed_of_new > 0 : kOnTheWay * refits[i].gained > behind;
      if (refits[i].settled || !(due || (i < among && !far))) continue;
      news = true;
      if (unknown) --owed_of_new;
      const double before = fit.objective();
      const long played = fit.rollouts();
      const double gained = fit.refresh(newsOf());
      const double lead = i == 0 && refits.size() > 1 ? refits[1].fit->objective() - fit.objective() : 0.0;
      refits[i].settled = enough(gained, fit.objective()) || gained < kOfLead * lead;
      ++refits[i].refreshed;
      count(fit.rollouts() - played);
      refits[i].gained = before - fit.objective();
      most_gained = std::max(most_gained, refits[i].gained);
    }
  }
  std::ranges::stable_sort(refits, byObjective);
  // What stands beside the best, and has derivatives of its own, gets the same second look before it is refused.
  bringBack(refits.front(), refits.front().fit->objective());
  const ArmCause best = refits.front().cause();
  for (Refit& refit : std::span(refits).subspan(1)) {
    if (refit.refreshed > 0 && refit.standsBeside(best)) bringBack(refit, refits.front().fit->objective());
  }
  std::ranges::stable_sort(refits, byObjective);
}

/// Scans from where the model without another cause ended, and from the prior's mean while it has none.
/// \param[out] points  these places
MotionScan MotionSelector::lookAround(const MotionCauseFit& base, const std::vector<MotionHypothesis>& open,
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
  std::vector<ArmCause> causes = fit.causes();
  causes.erase(causes.begin() + static_cast<std::ptrdiff_t>(cause));
  auto left = descended(std::move(causes), [&](MotionCauseFit& one) { return one.beginWithout(fit, cause); });
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
  found.p = chanceOf(best.promised, placebos);
  for (const Refit& one : refits) {
    const ArmCause& cause = one.cause();
    const double odds = (base.objective() - one.fit->objective()) / variance;
    // What looks like the best and is still on its way may pass it yet.
    const bool may_pass = looksLike({cause.effect, cause.target, {}}, best.cause()) && !one.settled &&
                          one.fit->objective() - best.fit->objective() < kOnTheWay * one.gained;
    const bool rival = &one != &best && (may_pass || !toldApart(*best.fit, *one.fit, variance));
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
  std::vector<MotionHypothesis> open = hypotheses_;
  std::erase_if(open, [&](const MotionHypothesis& hypothesis) {
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
  if (scan.trials.empty() || chanceOf(scan.trials.front().gain, scan.placebos) > level_) {
    // However well it fits, none could be named.
    for (const MotionTrial& trial : std::span(scan.trials).first(std::min(kTold, scan.trials.size()))) {
      const MotionHypothesis& one = open[trial.hypothesis];
      records.push_back({base.causes().size() + 1, std::string(one.effect->name), one.target, kNotMeasured,
                         chanceOf(trial.gain, scan.placebos), "rejected: promises no more than its placebos",
                         trial.gain});
    }
    return std::nullopt;
  }
  plan_.begin(MotionPlan::kFits, rollouts_);
  std::vector<Refit> refits = refit(base, points, scan, open, {});
  if (refits.empty()) return std::nullopt;
  plan_.begin(MotionPlan::kDerivatives, rollouts_);
  settle(base, open, refits, 0);
  for (int wave = 0; wave < kMoreWaves && refits.front().fit->misfit() > kLeavesMuch; ++wave) {
    // What the scan liked less: it looked from where the model without the cause was lost.
    std::vector<Refit> more = refit(base, points, scan, open, refits);
    if (more.empty()) break;
    std::ranges::move(more, std::back_inserter(refits));
    settle(base, open, refits, kOwedOfMore);
  }
  points.clear();
  improveBase(base, *refits.front().fit);
  return conclude(base, refits, scan.placebos, records);
}

}  // namespace simgap
