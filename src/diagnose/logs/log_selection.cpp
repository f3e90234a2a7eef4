#include "log_selection.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <set>

#include "trial_tests.h"

namespace simgap {
namespace {

/// Two causes whose validation errors differ by less than that share of the gain cannot be told apart.
constexpr double kTie = 0.03;
/// Where no cause explains so much, two that each explain the lesser share may together.
constexpr double kClear = 0.5, kPromising = 0.1;

/// Models with the first cause, the first two … of `selection.chosen`.
void rebuildSteps(const LogSearch& search, std::size_t own, Selection& selection) {
  selection.steps = {selection.baseline};
  const std::vector<const ActuatorEffect*> effects = selection.chosen.model->effects();
  const std::size_t causes = effects.size() - own;
  for (std::size_t k = 1; k <= causes; ++k) {
    const std::vector<const ActuatorEffect*> some(effects.begin(),
                                                  effects.begin() + static_cast<std::ptrdiff_t>(own + k));
    selection.steps.push_back(k == causes ? selection.chosen : search.fit(some, &selection.chosen));
  }
}

/// Takes out what is known of a cause.
void forget(std::size_t cause, Selection& selection) {
  const auto at = static_cast<std::ptrdiff_t>(cause);
  selection.p_adjusted.erase(selection.p_adjusted.begin() + at);
  selection.ambiguous_with.erase(selection.ambiguous_with.begin() + at);
  selection.instead.erase(selection.instead.begin() + at);
}

class Selector {
 public:
  Selector(const LogSearch& search, const std::vector<Hypothesis>& hypotheses, const LogDiagnosisOptions& options,
           const DiagnosisProgress& progress)
      : search_(search), hypotheses_(hypotheses), options_(options), progress_(progress) {}

  Selection run(const std::vector<const ActuatorEffect*>& own, const std::vector<Hypothesis>& unnamed);
  /// Of a selection that lost causes since.
  Selection reviewed(std::size_t own, Selection selection);

 private:
  double adjusted(const Trial& trial, std::size_t count) const {
    return std::min(1.0, trial.p * static_cast<double>(count));  // Holm's first step: the smallest of `count`
  }
  bool acceptable(const Trial& trial, std::size_t count) const {
    return trial.gain && trial.gain->value >= options_.least_gain && trial.gain->lower95 > 0.0 &&
           adjusted(trial, count) < options_.level;
  }
  std::optional<std::size_t> best(const Fitted& base, const std::vector<Trial>& trials) const;
  std::size_t simplest(const Fitted& base, const std::vector<Trial>& trials, std::size_t best) const;
  enum class Open { kNotDropped, kAll };
  std::vector<Trial> step(const Fitted& base, Open open, const Fitted* near = nullptr);
  /// Two causes at once: which of the trials is the first, and those on top of it.
  struct Pair {
    std::size_t first, second;
    std::vector<Trial> seconds;
    const Trial& both() const { return seconds[second]; }
  };
  std::optional<Pair> bestPair(const std::vector<Trial>& trials, std::optional<std::size_t> accepted);
  std::vector<std::size_t> promising(const std::vector<Trial>& trials) const;
  void accept(std::vector<Trial> trials, std::size_t accepted);
  void record(const std::vector<Trial>& trials, std::optional<std::size_t> accepted);
  /// Of the chosen model over one with a cause less.
  double gainOver(const Fitted& rest) const { return 1.0 - selection_.chosen.validation.mse() / rest.validation.mse(); }
  bool standsForAll(std::size_t cause, const Fitted& others) const;
  void prune();
  void review();
  void dropStandIns();
  void drop(std::size_t k, const Fitted& rest, double gain);
  std::vector<Trial> runnersUp(const std::vector<Trial>& trials, std::size_t accepted) const;
  std::vector<std::string> rivals(const Fitted& base, const std::vector<Trial>& trials, std::size_t accepted) const;
  Fitted validatedWithout(const Fitted& fitted, std::size_t cause) const;
  std::size_t causes() const { return selection_.chosen.model->effects().size() - own_; }
  void tell(const std::string& what, double done) const {
    if (progress_) progress_(what, done);
  }

  const LogSearch& search_;
  const std::vector<Hypothesis>& hypotheses_;
  const LogDiagnosisOptions& options_;
  const DiagnosisProgress& progress_;
  Selection selection_;
  std::size_t own_ = 0;
  std::size_t step_ = 0;
  std::set<std::string_view> dropped_;  ///< by pruning: what takes their place stays, or the steps would never end
};

/// Of the causes that gain as much as the best, or say the same, the one that fits the fewest numbers: what a bias
/// explains, a bias that changes in the middle of the log explains a little better.
std::size_t Selector::simplest(const Fitted& base, const std::vector<Trial>& trials, std::size_t best) const {
  const double enough = (1.0 - kTie) * trials[best].gain->value;
  std::size_t simplest = best;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    const ActuatorEffect& effect = *trials[t].hypothesis.effect;
    if (effect.name == trials[best].hypothesis.effect->name || !acceptable(trials[t], trials.size())) continue;
    if (sizesOf(effect) >= sizesOf(*trials[simplest].hypothesis.effect)) continue;
    if (trials[t].gain->value >= enough || saysTheSame(base, trials[best], trials[t])) simplest = t;
  }
  return simplest;
}

std::optional<std::size_t> Selector::best(const Fitted& base, const std::vector<Trial>& trials) const {
  std::optional<std::size_t> best;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    if (!acceptable(trials[t], trials.size())) continue;
    if (!best || trials[t].gain->value > trials[*best].gain->value) best = t;
  }
  return best ? std::optional(simplest(base, trials, *best)) : std::nullopt;
}

std::vector<Trial> Selector::step(const Fitted& base, Open open, const Fitted* near) {
  std::vector<Hypothesis> tried;
  for (const Hypothesis& h : hypotheses_) {
    const std::vector<const ActuatorEffect*>& in = base.model->effects();
    const bool chosen = std::ranges::find(in, h.effect->name, &ActuatorEffect::name) != in.end();
    if (!chosen && (open == Open::kAll || !dropped_.contains(h.effect->name))) tried.push_back(h);
  }
  return search_.tryAll(base, tried, near);
}

/// The few that gain most, significant or not: firsts of pairs.
std::vector<std::size_t> Selector::promising(const std::vector<Trial>& trials) const {
  constexpr std::size_t kMost = 3;
  std::vector<std::size_t> few;
  const auto gains = [](const Trial& trial) { return trial.gain->value >= kPromising; };
  for (const Trial* trial : oneOfEach(byGain(trials, gains), kMost)) few.push_back(trial - trials.data());
  return few;
}

/// What two causes leave may be far less than what either leaves alone: a weight that is not in the model hides how
/// friction heats up, and heat the weight, until neither is significant, or a third takes their place. Each of a pair
/// has to be significant beside the other, among all pairs that were tried.
std::optional<Selector::Pair> Selector::bestPair(const std::vector<Trial>& trials,
                                                 std::optional<std::size_t> accepted) {
  if (accepted && trials[*accepted].gain->value >= kClear) return std::nullopt;
  const std::vector<std::size_t> firsts = promising(trials);
  std::optional<Pair> best;
  for (const std::size_t first : firsts) {
    Pair pair{first, 0, step(trials[first].fitted, Open::kNotDropped)};
    const std::size_t tried = firsts.size() * pair.seconds.size();
    std::optional<std::size_t> second;
    for (std::size_t t = 0; t < pair.seconds.size(); ++t) {
      const Trial& trial = pair.seconds[t];
      if (!acceptable(trial, tried) || trial.gain->value < kPromising) continue;
      if (!second || trial.gain->value > pair.seconds[*second].gain->value) second = t;
    }
    if (!second) continue;
    pair.second = *second;
    const Fitted& both = pair.both().fitted;
    if (best && both.validation.mse() >= best->both().fitted.validation.mse()) continue;
    const Fitted rest = validatedWithout(both, both.model->effects().size() - 2 - own_);
    const double gain = 1.0 - both.validation.mse() / rest.validation.mse();
    const double p = pairedP(rest.validation, both.validation) * static_cast<double>(tried);
    if (gain >= kPromising && p < options_.level) best = std::move(pair);
  }
  return best && best->first != accepted ? std::move(best) : std::nullopt;
}

void Selector::record(const std::vector<Trial>& trials, std::optional<std::size_t> accepted) {
  ++step_;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    const Trial& trial = trials[t];
    HypothesisRecord entry{step_, titleOf(*trial.hypothesis.effect), trial.hypothesis.target, kNotMeasured, 1.0, {},
                           {}};
    if (!trial.identifiable) {
      entry.outcome = "not identifiable: the model's own parameters can imitate it";
    } else if (!trial.gain) {
      entry.gain_inner = {trial.gain_training, trial.gain_training, trial.gain_training};
      entry.outcome = "rejected: too small, or gains too little on the rows it was fitted to";
    } else {
      entry.gain_inner = *trial.gain;
      entry.p_adjusted = adjusted(trial, trials.size());
      entry.outcome = accepted == t                             ? "accepted"
                      : acceptable(trial, trials.size())        ? "significant, but another gains more"
                      : trial.gain->value < options_.least_gain ? "rejected: gains too little on unseen blocks"
                                                                : "rejected: not significant";
    }
    selection_.records.push_back(entry);
  }
}

std::vector<std::string> Selector::rivals(const Fitted& base, const std::vector<Trial>& trials,
                                          std::size_t accepted) const {
  const Trial& winner = trials[accepted];
  std::vector<std::string> names;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    const std::string name(trials[t].hypothesis.effect->name);
    const bool known = name == winner.hypothesis.effect->name || std::ranges::find(names, name) != names.end();
    if (known || !acceptable(trials[t], trials.size())) continue;  // other forms of a cause are no rivals
    // A bias from a moment on is one from the beginning, too: what a bias explains it explains.
    if (trials[t].hypothesis.effect->at_moment && winner.hypothesis.effect->is_bias) continue;
    const double lead = winner.gain->value - trials[t].gain->value;
    const bool tie = pairedP(trials[t].fitted.validation, winner.fitted.validation) > options_.level ||
                     lead < kTie * winner.gain->value;
    if (tie ? !search_.encompasses(winner, trials[t]) : saysTheSame(base, winner, trials[t])) names.push_back(name);
  }
  return names;
}

/// The causes that gain most beside the accepted one, significant or not: what a diagnosis has to be asked about.
std::vector<Trial> Selector::runnersUp(const std::vector<Trial>& trials, std::size_t accepted) const {
  constexpr std::size_t kMost = 2;
  const auto other = [&](const Trial& trial) {
    return trial.hypothesis.effect->name != trials[accepted].hypothesis.effect->name && trial.gain->value > 0.0;
  };
  std::vector<Trial> best;
  for (const Trial* trial : oneOfEach(byGain(trials, other), kMost)) best.push_back(*trial);
  return best;
}

Fitted Selector::validatedWithout(const Fitted& fitted, std::size_t cause) const {
  Fitted rest = search_.without(fitted, own_ + cause);
  search_.validate(rest);
  return rest;
}

void Selector::drop(std::size_t k, const Fitted& rest, double gain) {
  const ActuatorEffect* effect = selection_.chosen.model->effects()[own_ + k];
  selection_.records.push_back({step_, titleOf(*effect), {}, {gain, gain, gain}, 1.0, "pruned"});
  dropped_.insert(effect->name);
  selection_.chosen = rest;
  forget(k, selection_);
}

/// Whether a cause alone says nearly what two others and more say together without it, and by fewer numbers.
bool Selector::standsForAll(std::size_t cause, const Fitted& others) const {
  constexpr double kNearly = 0.9;  // of the gain
  if (causes() < 3) return false;
  const std::vector<const ActuatorEffect*>& effects = selection_.chosen.model->effects();
  std::vector<const ActuatorEffect*> one(effects.begin(), effects.begin() + static_cast<std::ptrdiff_t>(own_));
  one.push_back(effects[own_ + cause]);
  std::size_t sizes = 0;
  for (std::size_t k = 0; k < causes(); ++k) sizes += k == cause ? 0 : sizesOf(*effects[own_ + k]);
  if (sizesOf(*one.back()) >= sizes) return false;
  Fitted alone = search_.fit(one, &selection_.chosen);
  search_.validate(alone);
  const double before = selection_.baseline.validation.mse();
  return before - alone.validation.mse() >= kNearly * (before - others.validation.mse());
}

/// Takes out causes that the others made superfluous, or all others where it is they that are.
void Selector::prune() {
  for (std::size_t k = causes(); k-- > 0 && causes() > 1;) {
    const Fitted rest = validatedWithout(selection_.chosen, k);
    const double gain = gainOver(rest);
    if (gain >= options_.least_gain && pairedP(rest.validation, selection_.chosen.validation) < options_.level)
      continue;
    if (!standsForAll(k, rest)) {
      drop(k, rest, gain);
      continue;
    }
    while (causes() > 1) {
      const std::size_t other = causes() - 1 > k ? causes() - 1 : --k;
      const Fitted without = validatedWithout(selection_.chosen, other);
      drop(other, without, gainOver(without));
    }
  }
}

/// Takes out named causes that only stood in for what has no name: with that in the model they gain nothing.
void Selector::dropStandIns() {
  Fitted full = selection_.unnamed->fitted;
  for (std::size_t k = causes(); k-- > 0;) {
    Fitted rest = validatedWithout(full, k);
    const double gain = 1.0 - full.validation.mse() / rest.validation.mse();
    if (gain >= options_.least_gain) continue;
    drop(k, validatedWithout(selection_.chosen, k), gain);
    full = std::move(rest);
  }
  selection_.unnamed->gain = pairedGain(selection_.chosen.validation, full.validation, options_.seed);
}

/// The first causes were chosen without the later ones, and some were dropped for company that they no longer have:
/// each is compared with all its rivals again.
void Selector::review() {
  for (std::size_t k = 0; k < causes(); ++k) {
    const Fitted rest = validatedWithout(selection_.chosen, k);
    const std::vector<Trial> trials = step(rest, Open::kAll, &selection_.chosen);
    const auto winner = best(rest, trials);
    record(trials, winner);
    if (!winner) continue;
    const ActuatorEffect* present = selection_.chosen.model->effects()[own_ + k];
    const auto current = std::ranges::find_if(trials, [&](const Trial& t) { return t.hypothesis.effect == present; });
    const auto at = static_cast<std::size_t>(current - trials.begin());
    // Beside later causes, which may not stay, it moves to where it would be no finding; it still explains the most.
    if (!current->gain && current->gain_training > trials[*winner].gain_training) continue;
    // What says more by fewer numbers stands for its group: of those that data cannot tell apart, the simplest.
    const bool simpler = sizesOf(*trials[*winner].hypothesis.effect) < sizesOf(*present);
    const bool swap =
        *winner != at && (!current->gain || simpler ||
                          pairedP(current->fitted.validation, trials[*winner].fitted.validation) < options_.level);
    const std::size_t chosen = swap ? *winner : at;
    selection_.ambiguous_with[k] = rivals(rest, trials, chosen);
    selection_.instead[k] = runnersUp(trials, chosen);
    selection_.p_adjusted[k] = adjusted(trials[chosen], trials.size());
    if (!swap) continue;
    std::vector<const ActuatorEffect*> effects = selection_.chosen.model->effects();
    effects[own_ + k] = trials[chosen].hypothesis.effect;
    selection_.chosen = search_.fit(effects, &trials[chosen].fitted);
    search_.validate(selection_.chosen);
  }
}

void Selector::accept(std::vector<Trial> trials, std::size_t accepted) {
  selection_.last = std::move(trials);
  const Trial& winner = selection_.last[accepted];
  selection_.p_adjusted.push_back(adjusted(winner, selection_.last.size()));
  selection_.ambiguous_with.push_back(rivals(selection_.chosen, selection_.last, accepted));
  selection_.instead.push_back(runnersUp(selection_.last, accepted));
  selection_.chosen = winner.fitted;
}

Selection Selector::run(const std::vector<const ActuatorEffect*>& own, const std::vector<Hypothesis>& unnamed) {
  own_ = own.size();
  tell("fitting the model as it is", 0.0);
  selection_.baseline = search_.fit(own, nullptr);
  search_.validate(selection_.baseline);
  selection_.chosen = selection_.baseline;
  const double share = 0.8 / (options_.max_causes + 1.0);
  while (static_cast<int>(causes()) < options_.max_causes) {
    tell("trying causes", 0.1 + share * static_cast<double>(step_));
    std::vector<Trial> trials = step(selection_.chosen, Open::kNotDropped);
    auto accepted = best(selection_.chosen, trials);
    std::optional<Pair> pair =
        static_cast<int>(causes()) + 2 <= options_.max_causes ? bestPair(trials, accepted) : std::nullopt;
    if (pair) accepted = pair->first;
    record(trials, accepted);
    if (step_ == 1) selection_.aliased = aliased(trials);
    if (!accepted) {
      selection_.last = std::move(trials);
      break;
    }
    accept(std::move(trials), *accepted);
    if (pair) {
      record(pair->seconds, pair->second);
      accept(std::move(pair->seconds), pair->second);
    }
    prune();
  }
  tell("comparing each cause with its rivals", 0.8);
  if (causes() > 1 || !dropped_.empty()) review();
  prune();
  tell("looking for what has no name", 0.9);
  const std::vector<Trial> strange = search_.tryAll(selection_.chosen, unnamed);
  const auto found = best(selection_.chosen, strange);
  record(strange, found);
  if (found) {
    selection_.unnamed = strange[*found];
    dropStandIns();
  }
  rebuildSteps(search_, own_, selection_);
  return std::move(selection_);
}

Selection Selector::reviewed(std::size_t own, Selection selection) {
  own_ = own;
  selection_ = std::move(selection);
  if (!selection_.records.empty()) step_ = selection_.records.back().step;
  search_.validate(selection_.chosen);
  review();
  rebuildSteps(search_, own_, selection_);
  return std::move(selection_);
}

}  // namespace

void dropCause(const LogSearch& search, std::size_t own, std::size_t cause, Selection& selection) {
  selection.chosen = search.without(selection.chosen, own + cause);
  forget(cause, selection);
  rebuildSteps(search, own, selection);
}

void reviewCauses(const LogSearch& search, std::size_t own, const std::vector<Hypothesis>& hypotheses,
                  const LogDiagnosisOptions& options, Selection& selection) {
  const DiagnosisProgress silent;
  selection = Selector(search, hypotheses, options, silent).reviewed(own, std::move(selection));
}

Selection selectCauses(const LogSearch& search, const std::vector<const ActuatorEffect*>& own,
                       const std::vector<Hypothesis>& hypotheses, const std::vector<Hypothesis>& unnamed,
                       const LogDiagnosisOptions& options, const DiagnosisProgress& progress) {
  return Selector(search, hypotheses, options, progress).run(own, unnamed);
}

}  // namespace simgap
