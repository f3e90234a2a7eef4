#include "log_candidates.h"

#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "log_causes.h"
#include "simgap/optimize/uncertainty.h"

namespace simgap {
namespace {

using Effects = std::vector<const ActuatorEffect*>;

struct Asked {
  Fitted fitted;  ///< to the training blocks
  const char* role;
};

std::string labelOf(const Effects& effects, std::size_t own) {
  std::string label;
  for (std::size_t e = own; e < effects.size(); ++e) {
    label += (label.empty() ? "" : ", ") + std::string(effects[e]->name);
  }
  return label.empty() ? "none" : label;
}

std::set<std::string_view> namesOf(const Effects& effects) {
  std::set<std::string_view> names;
  for (const ActuatorEffect* effect : effects) names.insert(effect->name);
  return names;
}

/// The chosen model with another cause in the place of each of its own.
void addInstead(const LogSearch& search, const Selection& selection, std::size_t own, std::vector<Asked>& asked) {
  for (std::size_t k = 0; k < selection.instead.size(); ++k) {
    for (const Trial& trial : selection.instead[k]) {
      Effects effects = selection.chosen.model->effects();
      if (namesOf(effects).contains(trial.hypothesis.effect->name)) continue;
      effects[own + k] = trial.hypothesis.effect;
      asked.push_back({search.fit(effects, &trial.fitted), "instead"});
    }
  }
}

/// The chosen model with one cause more that was not believed: first those that had been accepted.
void addRefused(const LogSearch& search, const Selection& selection, const std::vector<Candidate>& refused,
                const std::vector<Hypothesis>& hypotheses, std::vector<Asked>& asked) {
  constexpr std::size_t kMost = 3;
  std::set<std::string_view> held = namesOf(selection.chosen.model->effects());
  std::size_t count = 0;
  const auto add = [&](const Fitted& fitted, std::string_view name) {
    if (count >= kMost || fitted.theta.empty() || !held.insert(name).second) return;
    asked.push_back({fitted, "refused"});
    ++count;
  };
  for (const Candidate& candidate : refused) {
    std::vector<Hypothesis> forms;
    for (const Hypothesis& h : hypotheses) {
      if (h.effect->name == candidate.effect && !held.contains(h.effect->name)) forms.push_back(h);
    }
    const std::vector<Trial> trials = search.tryAll(selection.chosen, forms);
    const auto best = std::ranges::max_element(trials, {}, &Trial::gain_training);
    if (best != trials.end() && best->identifiable) add(best->fitted, best->hypothesis.effect->name);
  }
  const auto helps = [&](const Trial& trial) {
    // Tried on top of what was chosen then: of the same model only what was not changed since.
    const bool on_top =
        trial.fitted.model && trial.fitted.model->effects().size() == selection.chosen.model->effects().size() + 1;
    return on_top && trial.identifiable && trial.gain->value > 0.0;
  };
  for (const Trial* trial : byGain(selection.last, helps)) {
    Effects effects = selection.chosen.model->effects();
    if (held.contains(trial->hypothesis.effect->name)) continue;
    effects.push_back(trial->hypothesis.effect);
    add(search.fit(effects, &trial->fitted), trial->hypothesis.effect->name);
  }
}

}  // namespace

double freedomOf(const GroupErrors& errors) {
  std::vector<double> means;
  for (Eigen::Index k = 0; k < errors.sum.size(); ++k) {
    if (errors.rows[k] > 0.0) means.push_back(errors.sum[k] / errors.rows[k]);
  }
  if (means.size() < 3) return 1.0;
  const auto n = static_cast<double>(means.size());
  const Eigen::ArrayXd q = Eigen::ArrayXd::Map(means.data(), std::ssize(means));
  const Eigen::VectorXd spread = (q - q.mean()).matrix();
  const double variance = spread.squaredNorm() / (n - 1.0);
  if (!(variance > 0.0)) return 2.0 * n;
  const double alike = correlationTime(spread, std::vector<int>(means.size(), 0));
  return std::clamp(2.0 * q.mean() * q.mean() / variance * n / alike, 1.0, 1e6);
}

std::vector<FittedLogCandidate> logCandidates(const LogSearch& search, const PreparedLog& log,
                                              const Selection& selection, const std::vector<Candidate>& refused,
                                              const std::vector<Hypothesis>& hypotheses, std::size_t own,
                                              double correlation) {
  std::vector<Asked> asked = {{selection.chosen, "named"}};
  addInstead(search, selection, own, asked);
  addRefused(search, selection, refused, hypotheses, asked);
  if (selection.chosen.model->effects().size() > own) asked.push_back({selection.baseline, "without"});
  std::vector<FittedLogCandidate> candidates(asked.size());
  tbb::parallel_for(std::size_t{0}, asked.size(), [&](std::size_t i) {
    Fitted& fitted = asked[i].fitted;
    search.validate(fitted);
    LogPosterior posterior;
    posterior.variance = fitted.validation.mse();
    posterior.freedom = freedomOf(fitted.validation);
    auto [fit, covariance] = describeFully(search, log, fitted);
    posterior.covariance = std::move(covariance);
    for (const ParameterSpec& p : fitted.model->parameters()) posterior.names.push_back(p.name);
    candidates[i] = {{labelOf(fit.effects, own), asked[i].role, std::move(posterior)}, std::move(fit)};
  });
  double rows = 0.0;
  for (const Block& b : search.training()) rows += static_cast<double>(b.size());
  const double named = candidates.front().candidate.posterior.variance;
  for (FittedLogCandidate& c : candidates) {
    c.candidate.posterior.log_odds = 0.5 * rows / correlation * std::log(named / c.candidate.posterior.variance);
  }
  return candidates;
}

}  // namespace simgap
