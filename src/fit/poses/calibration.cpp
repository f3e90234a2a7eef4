#include "simgap/fit/poses/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <map>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

std::vector<ObjectParameter> objectParameters(const ParameterSpace& space) {
  std::vector<ObjectParameter> parameters;
  for (const SearchParameter& p : space.parameters()) parameters.push_back({p.initial, p.step, p.lower, p.upper});
  return parameters;
}

}  // namespace

Calibration::Calibration(const ArmModel& model, std::span<const Pose> poses, const CalibrationConfig& config,
                         Evaluator& evaluator, int threads)
    : model_(model),
      layout_(model.poseLayout()),
      poses_(poses),
      config_(config),
      evaluator_(evaluator),
      threads_(threads),
      space_(model, config.parameters),
      strategy_(objectParameters(space_), config.strategy),
      offspring_(static_cast<std::size_t>(config.strategy.lambda), model) {}

void Calibration::restore(CalibrationState state) {
  if (config_.optimizer != "es") {
    const auto size = static_cast<Eigen::Index>(space_.size());
    const auto fits = [&](const PosteriorFit& fit) { return fit.z.size() == size; };
    if ((state.journal.whitened_at.size() != 0 && state.journal.whitened_at.size() != size) ||
        (state.journal.whitened_at.size() == 0 && !state.journal.fits.empty()) ||
        !std::all_of(state.journal.fits.begin(), state.journal.fits.end(), fits)) {
      throw ConfigError(fmt::format("the stored state is not one of {} parameters", space_.size()));
    }
    state_ = std::move(state);
    return;
  }
  const std::size_t joints = layout_.joints.size();
  const auto fits = [&](const GenerationRecord& record) { return record.mje.size() == joints; };
  if (state.strategy.best.y.size() != space_.size() || state.best_mje.size() != joints ||
      !std::all_of(state.history.begin(), state.history.end(), fits)) {
    throw ConfigError(fmt::format("the stored state is not one of {} parameters and {} joints", space_.size(), joints));
  }
  state_ = std::move(state);
  strategy_ = EvolutionStrategy(objectParameters(space_), config_.strategy, state_.strategy);
}

void Calibration::run(const std::function<void(const CalibrationState&)>& after_generation) {
  if (config_.optimizer == "es") return runEvolutionStrategy(after_generation);
  // They pass again through what is known already, which costs next to nothing.
  CalibrationState begun;
  begun.told = std::move(state_.told);
  begun.journal = std::move(state_.journal);
  begun.wall = state_.wall;
  state_ = std::move(begun);
  config_.optimizer == "cma-es" ? runCmaEs(after_generation) : searchPosterior(after_generation);
}

void Calibration::runEvolutionStrategy(const AfterGeneration& after_generation) {
  using Clock = std::chrono::steady_clock;
  while (!strategy_.stopped()) {
    const auto start = Clock::now();
    evaluateGeneration();
    state_.wall += std::chrono::duration<double>(Clock::now() - start).count();
    after_generation(state_);
  }
}

void Calibration::evaluateGeneration() {
  const std::vector<Individual>& individuals = strategy_.ask();
  for (std::size_t k = 0; k < individuals.size(); ++k) space_.apply(individuals[k].y, offspring_[k]);
  const std::vector<PoseOutcome> outcomes = evaluator_.evaluate(offspring_, poses_, AfterInvalid::kSkipRest);
  if (interruptRequested()) throw InterruptedError("interrupted");

  std::vector<double> fitness(individuals.size());
  std::vector<double> valid;
  std::size_t best = 0;
  std::vector<double> best_mje;
  for (std::size_t k = 0; k < individuals.size(); ++k) {
    const Assessment judged =
        assess(layout_, poses_, std::span(outcomes).subspan(k * poses_.size(), poses_.size()), config_.objective);
    fitness[k] = judged.fitness;
    if (std::isnan(judged.fitness)) continue;
    if (valid.empty() || judged.fitness < fitness[best]) {
      best = k;
      best_mje = judged.mje;
    }
    valid.push_back(judged.fitness);
  }
  const double best_before = strategy_.state().best.fitness;
  if (valid.empty() && std::isnan(best_before)) failWithoutValidIndividual(outcomes);
  if (!valid.empty() && !(best_before <= fitness[best])) state_.best_mje = best_mje;

  GenerationRecord record;
  if (!valid.empty()) noteSteps(individuals[best], record);
  strategy_.tell(fitness);
  record.generation = strategy_.state().generation;
  record.best = valid.empty() ? std::numeric_limits<double>::quiet_NaN() : fitness[best];
  record.median = valid.empty() ? std::numeric_limits<double>::quiet_NaN() : median(valid);
  record.best_so_far = strategy_.state().best.fitness;
  record.invalid = static_cast<int>(individuals.size() - valid.size());
  record.mje = state_.best_mje;
  state_.strategy = strategy_.state();
  state_.history.push_back(record);
  state_.invalid += record.invalid;
  state_.evaluations += std::ssize(outcomes);
}

void Calibration::noteSteps(const Individual& individual, GenerationRecord& record) const {
  std::vector<double> relative;
  for (std::size_t j = 0; j < space_.size(); ++j) relative.push_back(individual.s[j] / space_.parameters()[j].step);
  const auto [smallest, largest] = std::minmax_element(relative.begin(), relative.end());
  record.sigma_min = *smallest;
  record.sigma_median = median(relative);
  record.sigma_max = *largest;
}

void Calibration::failWithoutValidIndividual(std::span<const PoseOutcome> outcomes) const {
  struct Reason {
    int count = 0;
    std::string worst;
    double worst_value = -kInfinity;  // a simulation that blew up has none
  };
  std::map<PoseStatus, Reason> reasons;
  for (std::size_t task = 0; task < outcomes.size(); ++task) {
    const PoseOutcome& outcome = outcomes[task];
    if (outcome.status == PoseStatus::kSteady || outcome.status == PoseStatus::kSkipped) continue;
    Reason& reason = reasons[outcome.status];
    ++reason.count;
    if (outcome.worst_value <= reason.worst_value) continue;
    reason.worst_value = outcome.worst_value;
    reason.worst = fmt::format("{} in pose {}", describe(outcome, layout_), poses_[task % poses_.size()].name);
  }
  std::string sentence = fmt::format("no valid individual in generation {}:", strategy_.state().generation + 1);
  std::string separator = " ";
  for (const auto& [status, reason] : reasons) {
    sentence += fmt::format("{}{} x {} (worst: {})", separator, reason.count, toString(status), reason.worst);
    separator = ", ";
  }
  const bool simulated = config_.evaluator == "bullet";
  throw NumericsError(sentence + "; smaller steps" +
                      (simulated ? " or a longer protocol in --config may help, or equilibria, which need no way there "
                                   "(--evaluator equilibrium --verify none)"
                                 : " in --config may help, or --optimizer lm"));
}

ArmModel Calibration::bestModel() const {
  ArmModel model = model_;
  if (!state_.strategy.best.y.empty()) space_.apply(state_.strategy.best.y, model);
  return model;
}

}  // namespace simgap
