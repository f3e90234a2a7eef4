#include <algorithm>
#include <array>
#include <cmath>
#include <span>

#include "motion_selection.h"

namespace simgap {
namespace {

constexpr std::array<std::size_t, 5> kRefreshed = {3, 2, 2, 1, 1};  // at most, with derivatives of their own
constexpr std::size_t kMostRounds = 14;                             // the best, and what may still pass it, alone
constexpr double kOfLead = 1e-3;  // of its lead, that a round of the best gains: it need not come to its end
constexpr int kRoundsBack = 8;

}  // namespace

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

/// New derivatives as long as a fit may still come as far as the best.
void MotionSelector::catchUp(MotionCauseFit& fit, double least) {
  const long before = fit.rollouts();
  for (int round = 0; round < kRoundsBack; ++round) {
    const double gained = fit.refresh(newsOf());
    if (enough(gained, fit.objective()) || fit.objective() - least > kOnTheWay * gained) break;
  }
  count(fit.rollouts() - before);
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
  catchUp(*best, least);
  if (best->objective() < refit.fit->objective()) refit.fit = std::move(best);
}

/// What the catalogue says is hard to tell from the best, and the best's own effect on other targets, once more from
/// where that one stands, whether or not the scan liked them: it looked from where the model without a cause was, which
/// may be far from where the ordinary parameters belong.
void MotionSelector::startBesideBest(const MotionCauseFit& base, const std::vector<ArmHypothesis>& open,
                                     std::vector<Refit>& refits) {
  const MotionLinearisation there = refits.front().fit->withoutLastCause();
  const MotionPoint point(base.posterior(), there);
  const ArmCause best = refits.front().cause();
  const double promised = refits.front().promised;
  for (const ArmHypothesis& hypothesis : open) {
    const auto fitted =
        std::ranges::find_if(refits, [&](const Refit& refit) { return hypothesis.isOf(refit.cause()); });
    const bool kin = fitted != refits.end() && hypothesis.effect == best.effect;
    if (fitted == refits.begin() || !(kin || looksLike(hypothesis, best))) continue;
    const ArmCause cause = fitted == refits.end()
                               ? ArmCause{hypothesis.effect, hypothesis.target, hypothesis.starts.front()}
                               : fitted->cause();
    auto other =
        descended(withOneMore(base.causes(), cause), [&](MotionCauseFit& one) { return one.beginBeside(point); });
    if (!other) continue;
    if (fitted == refits.end()) {
      refits.push_back({std::move(other), promised});
    } else if (other->objective() < fitted->fit->objective()) {
      fitted->fit = std::move(other);
      fitted->promised = std::max(fitted->promised, promised);
    }
  }
}

/// The best is brought back, and what stands beside it before it is refused: from where the best stands, too.
void MotionSelector::lookAgain(const MotionCauseFit& base, const std::vector<ArmHypothesis>& open,
                               std::vector<Refit>& refits) {
  bringBack(refits.front(), refits.front().fit->objective());
  startBesideBest(base, open, refits);
  const ArmCause best = refits.front().cause();
  const double least = refits.front().fit->objective();
  for (Refit& refit : std::span(refits).subspan(1)) {
    const bool kin = refit.cause().effect == best.effect;
    if (!refit.standsBeside(best) || (refit.refreshed == 0 && !kin)) continue;
    catchUp(*refit.fit, least);
    bringBack(refit, least);
  }
}

/// The best first.
void MotionSelector::sortBest(std::vector<Refit>& refits) {
  std::ranges::stable_sort(refits, {}, [](const Refit& refit) { return refit.fit->objective(); });
}

/// What was begun late and may pass the best goes on until it has, or cannot.
void MotionSelector::finishRivals(std::vector<Refit>& refits) {
  const Refit* best = &refits.front();
  const double least = best->fit->objective();
  for (Refit& refit : std::span(refits).subspan(1)) {
    if (!refit.mayPass(*best)) continue;
    catchUp(*refit.fit, least);
    refit.settled = true;
  }
  sortBest(refits);
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
void MotionSelector::settle(const MotionCauseFit& base, const std::vector<ArmHypothesis>& open,
                            std::vector<Refit>& refits, int owed_of_new) {
  double most_gained = 0.0;
  bool news = true;
  for (std::size_t round = 0; news && round < kMostRounds; ++round) {
    news = false;
    const std::size_t among = kRefreshed[std::min(round, kRefreshed.size() - 1)];
    sortBest(refits);
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
  sortBest(refits);
  lookAgain(base, open, refits);
  sortBest(refits);
}

}  // namespace simgap
