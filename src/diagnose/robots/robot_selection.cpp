#include "robot_selection.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <numeric>

#include "simgap/core/interrupt.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;

/// Two causes whose errors differ by less than that share of what the better one saves cannot be told apart.
constexpr double kRobotTie = 0.03;

RobotSearch::Set with(const RobotSearch::Set& set, std::size_t h) {
  RobotSearch::Set more = set;
  more.push_back(h);
  return more;
}

std::string titleOf(const RobotHypothesis& h) { return h.form.empty() ? h.cause : h.cause + " (" + h.form + ")"; }

}  // namespace

double waldP(const RobotSearch& search, const RobotSearch::Set& set) {
  const RobotSearch::Fit fit = search.fit(set, kRobotFolds);
  const MatrixXd covariance = search.covariance(set, fit);
  const Index first = covariance.rows() - fit.theta.back().size();
  const auto blocks = static_cast<double>(std::ranges::count(search.ground().training, true));
  double largest = 0.0, numbers = 0.0;
  for (Index k = 0; k < fit.theta.back().size(); ++k) {
    const double variance = covariance(first + k, first + k);
    if (!(variance > 0.0)) continue;
    ++numbers;
    largest = std::max(largest, std::abs(fit.theta.back()[k]) / std::sqrt(variance));
  }
  const double searched = search.hypothesis(set.back()).searched;
  return std::min(1.0, 2.0 * numbers * searched * studentTail(largest, blocks - 1.0));
}

RobotSelector::RobotSelector(RobotSearch& search, const RobotDiagnosisOptions& options)
    : search_(search), options_(options), everywhere_(search.rows().joints()), refused_(search.size(), false) {
  std::iota(everywhere_.begin(), everywhere_.end(), std::size_t{0});
}

RobotSelector::Start RobotSelector::startOf(RobotSearch::Set set) const {
  BlockErrors errors = search_.validate(set);
  const double cost = search_.fit(set, kRobotFolds).cost;
  return {std::move(set), std::move(errors), cost};
}

RobotTrial RobotSelector::tryOne(const Start& start, const BlockErrors& before, std::size_t h) const {
  RobotTrial trial;
  trial.hypothesis = h;
  const RobotSearch::Set more = with(start.set, h);
  const RobotSearch::Fit fit = search_.fit(more, kRobotFolds);
  const std::vector<bool>& training = search_.ground().training;
  const std::vector<std::size_t>& joints = search_.joints(h);
  const GroupErrors own = groupErrors(start.errors, search_.counted(), training, joints);
  // In units of the squared errors, which count every row in full.
  const double gain_training = (start.cost - fit.cost) * search_.ground().inflation / std::max(own.sum.sum(), 1e-300);
  if (gain_training < 0.5 * options_.least_gain) return trial;
  const RobotHypothesis& hypothesis = search_.hypothesis(h);
  if (hypothesis.counts && !hypothesis.counts(fit.theta.back())) return trial;
  trial.validation = search_.validate(more);
  const GroupErrors after = groupErrors(trial.validation, search_.counted(), training, joints);
  trial.gain = pairedGain(own, after, options_.seed);
  trial.saved = before.sum() - trial.validation.sum();
  trial.p = std::min(1.0, 2.0 * std::min(pairedP(own, after), waldP(search_, more)));
  return trial;
}

std::vector<RobotTrial> RobotSelector::step(const RobotSearch::Set& set) const {
  std::vector<std::size_t> open;
  for (std::size_t h = 0; h < search_.size(); ++h) {
    const bool taken = std::ranges::any_of(set, [&](std::size_t other) {
      return search_.hypothesis(other).label() == search_.hypothesis(h).label() &&
             search_.hypothesis(h).searched == 1.0;
    });
    const bool asked = search_.testable(h) && !search_.hypothesis(h).ordinary;
    if (asked && !taken && !refused_[h]) open.push_back(h);
  }
  // Starts: with the numbers of each drive free, and the set itself.
  std::vector<std::size_t> drives;
  for (const std::size_t h : open) {
    for (const std::size_t other : search_.beside(h)) {
      if (std::ranges::find(drives, other) == drives.end()) drives.push_back(other);
    }
  }
  std::vector<Start> starts(drives.size() + 1);
  tbb::parallel_for(std::size_t{0}, starts.size(),
                    [&](std::size_t s) { starts[s] = startOf(s < drives.size() ? with(set, drives[s]) : set); });
  std::vector<RobotTrial> trials(open.size());
  tbb::parallel_for(std::size_t{0}, open.size(), [&](std::size_t k) {
    if (interruptRequested()) return;
    const RobotSearch::Set other = search_.beside(open[k]);
    const auto s = other.empty() ? std::ssize(drives) : std::ranges::find(drives, other.front()) - drives.begin();
    trials[k] = tryOne(starts[s], starts.back().errors, open[k]);
  });
  stopIfInterrupted();
  for (RobotTrial& trial : trials) trial.p_adjusted = std::min(1.0, trial.p * static_cast<double>(trials.size()));
  return trials;
}

bool RobotSelector::overlap(const RobotSearch::Set& set, const RobotTrial& a, const RobotTrial& b) const {
  constexpr double kMost = 0.5;
  const auto cost = [&](const RobotSearch::Set& some) { return search_.fit(some, kRobotFolds).cost; };
  const RobotSearch::Set of_a = with(set, a.hypothesis);
  const double alone = cost(set) - cost(with(set, b.hypothesis));
  const double beside = cost(of_a) - cost(with(of_a, b.hypothesis));
  return beside < kMost * alone;
}

bool RobotSelector::acceptable(const RobotTrial& trial) const {
  return trial.gain && trial.saved > 0.0 && trial.gain->value >= options_.least_gain && trial.gain->lower95 > 0.0 &&
         trial.p_adjusted < options_.level;
}

/// Whether the errors on unseen blocks do not tell a trial from a better one.
bool RobotSelector::ties(const RobotTrial& trial, const RobotTrial& winner) const {
  const std::vector<bool>& training = search_.ground().training;
  const GroupErrors theirs = groupErrors(trial.validation, search_.counted(), training, everywhere_);
  const GroupErrors ours = groupErrors(winner.validation, search_.counted(), training, everywhere_);
  return winner.saved - trial.saved < kRobotTie * winner.saved || pairedP(theirs, ours) > options_.level;
}

/// The one that saves most; of those that unseen blocks do not tell from it the one with the fewest numbers.
std::optional<std::size_t> RobotSelector::best(const RobotSearch::Set& set,
                                               const std::vector<RobotTrial>& trials) const {
  std::optional<std::size_t> most;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    if (acceptable(trials[t]) && (!most || trials[t].saved > trials[*most].saved)) most = t;
  }
  if (!most) return most;
  std::size_t simplest = *most;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    if (t == *most || !acceptable(trials[t]) || !ties(trials[t], trials[*most])) continue;
    if (!overlap(set, trials[*most], trials[t])) continue;
    const std::size_t own = search_.freedom(trials[t].hypothesis), least = search_.freedom(trials[simplest].hypothesis);
    if (own < least || (own == least && trials[t].saved > trials[simplest].saved)) simplest = t;
  }
  return simplest;
}

/// A model with both shows that the winner says all that the rival says.
bool RobotSelector::encompasses(const RobotSearch::Set& set, const RobotTrial& winner, const RobotTrial& rival) const {
  constexpr double kAdds = 0.2;
  const RobotSearch::Set of_winner = with(set, winner.hypothesis), of_rival = with(set, rival.hypothesis);
  const RobotSearch::Set both = with(of_rival, winner.hypothesis);
  const double cost = search_.fit(both, kRobotFolds).cost;
  const double rival_adds = search_.fit(of_winner, kRobotFolds).cost - cost;
  const double winner_adds = search_.fit(of_rival, kRobotFolds).cost - cost;
  return winner_adds > 1.0 && rival_adds < kAdds * winner_adds && waldP(search_, both) < options_.level;
}

std::vector<std::string> RobotSelector::rivals(const RobotSearch::Set& set, const std::vector<RobotTrial>& trials,
                                               std::size_t winner) const {
  const RobotTrial& best = trials[winner];
  const std::string own = search_.hypothesis(best.hypothesis).label();
  std::vector<std::string> names;
  for (const RobotTrial& trial : trials) {
    const std::string name = search_.hypothesis(trial.hypothesis).label();
    if (name == own || std::ranges::find(names, name) != names.end()) continue;  // other forms are no rivals
    if (!acceptable(trial) || !ties(trial, best) || !overlap(set, best, trial)) continue;
    // With several numbers more it says the same and more: the simpler cause stands for both. One more is no argument:
    // a base tilted about the first joint's axis is as likely as a wrong zero of that joint.
    const bool simpler = search_.freedom(best.hypothesis) + 1 < search_.freedom(trial.hypothesis);
    if (simpler && search_.contains(trial.hypothesis, best.hypothesis)) continue;
    if (!encompasses(set, best, trial)) names.push_back(name);
  }
  return names;
}

void RobotSelector::record(const std::vector<RobotTrial>& trials, std::optional<std::size_t> accepted,
                           RobotSelection& selection) {
  ++step_;
  for (std::size_t t = 0; t < trials.size(); ++t) {
    const RobotTrial& trial = trials[t];
    const RobotHypothesis& h = search_.hypothesis(trial.hypothesis);
    HypothesisRecord entry{step_, titleOf(h), h.target, kNotMeasured, 1.0, {}};
    if (!trial.gain) {
      entry.outcome = "rejected: too small, or gains too little on the rows it was fitted to";
    } else {
      entry.gain_inner = *trial.gain;
      entry.p_adjusted = trial.p_adjusted;
      entry.outcome = accepted == t                             ? "accepted"
                      : acceptable(trial)                       ? "significant, but another gains more"
                      : trial.gain->value < options_.least_gain ? "rejected: gains too little on unseen blocks"
                                                                : "rejected: not significant";
    }
    selection.records.push_back(std::move(entry));
  }
}

void RobotSelector::remove(std::size_t cause, RobotSelection& selection) {
  selection.set = without(selection.set, cause);
  selection.p_adjusted.erase(selection.p_adjusted.begin() + static_cast<std::ptrdiff_t>(cause));
  selection.ambiguous_with.erase(selection.ambiguous_with.begin() + static_cast<std::ptrdiff_t>(cause));
}

/// Takes out causes that the later ones made superfluous.
void RobotSelector::prune(RobotSelection& selection) {
  const std::vector<bool>& training = search_.ground().training;
  for (std::size_t k = selection.set.size(); k-- > 0 && selection.set.size() > 1;) {
    const std::size_t h = selection.set[k];
    const BlockErrors all = search_.validate(selection.set);
    // What bends stands elsewhere without this one: a tilted base beside a wrong zero of the first joint, which is one.
    const RobotSearch::Set bare = bareOf(search_, selection.set, k);
    const bool bends = search_.settle(bare);
    const GroupErrors before = groupErrors(search_.validate(bare), search_.counted(), training, search_.joints(h));
    const GroupErrors after = groupErrors(all, search_.counted(), training, search_.joints(h));
    const double gain = 1.0 - after.mse() / before.mse();
    if (gain >= options_.least_gain && pairedP(before, after) < options_.level) {
      if (bends) search_.settle(selection.set);
      continue;
    }
    const RobotHypothesis& hypothesis = search_.hypothesis(h);
    selection.records.push_back({step_, titleOf(hypothesis), hypothesis.target, {gain, gain, gain}, 1.0, "pruned"});
    refused_[h] = true;
    remove(k, selection);
  }
}

/// The first causes were chosen without the later ones: each is compared with all its rivals again.
void RobotSelector::review(RobotSelection& selection) {
  for (std::size_t k = 0; k < selection.set.size(); ++k) {
    const RobotSearch::Set rest = without(selection.set, k);
    const std::vector<RobotTrial> trials = step(rest);
    const auto winner = best(rest, trials);
    record(trials, winner, selection);
    if (!winner) continue;
    const auto present =
        std::ranges::find(trials, selection.set[k], [](const RobotTrial& trial) { return trial.hypothesis; });
    const auto current = static_cast<std::size_t>(present - trials.begin());
    const bool stays = current < trials.size() &&
                       (current == *winner ||
                        (acceptable(trials[current]) &&
                         search_.freedom(trials[current].hypothesis) <= search_.freedom(trials[*winner].hypothesis) &&
                         ties(trials[current], trials[*winner])));
    const std::size_t chosen = stays ? current : *winner;
    selection.set[k] = trials[chosen].hypothesis;
    selection.p_adjusted[k] = trials[chosen].p_adjusted;
    selection.ambiguous_with[k] = rivals(rest, trials, chosen);
  }
}

void RobotSelector::grow(RobotSelection& selection, const DiagnosisProgress& progress) {
  while (static_cast<int>(selection.set.size()) < options_.max_causes) {
    if (progress) {
      progress("trying causes", 0.4 + 0.4 * static_cast<double>(selection.set.size()) / (options_.max_causes + 1.0));
    }
    const std::vector<RobotTrial> trials = step(selection.set);
    const auto accepted = best(selection.set, trials);
    record(trials, accepted, selection);
    if (!accepted) break;
    selection.p_adjusted.push_back(trials[*accepted].p_adjusted);
    selection.ambiguous_with.push_back(rivals(selection.set, trials, *accepted));
    selection.set.push_back(trials[*accepted].hypothesis);
    search_.settle(selection.set);
    prune(selection);
  }
}

RobotSelection RobotSelector::run(const DiagnosisProgress& progress) {
  RobotSelection selection;
  grow(selection, progress);
  if (selection.set.size() > 1) review(selection);
  prune(selection);
  return selection;
}

void RobotSelector::drop(std::size_t cause, RobotSelection& selection) {
  refused_[selection.set[cause]] = true;
  remove(cause, selection);
  if (!selection.set.empty()) review(selection);
}

}  // namespace simgap
