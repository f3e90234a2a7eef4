#include "simgap/fit/poses/calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>
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
  if (config_.optimizer != "es") return;  // run() begins anew, see there
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
  state_ = {};  // they repeat themselves to the last bit, so an interrupted run just starts again
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

  GenerationRecord record;
  std::vector<double> fitness(individuals.size());
  std::vector<double> valid;
  std::size_t best = 0;
  std::vector<double> best_mje;
  for (std::size_t k = 0; k < individuals.size(); ++k) {
    const Assessment judged = assess(layout_, poses_, std::span(outcomes).subspan(k * poses_.size(), poses_.size()));
    fitness[k] = judged.fitness;
    if (std::isnan(judged.fitness)) continue;
    if (valid.empty() || judged.fitness < fitness[best]) {
      best = k;
      best_mje = judged.mje;
    }
    valid.push_back(judged.fitness);
  }
  if (valid.empty()) failWithoutValidIndividual(outcomes);

  std::vector<double> relative_steps;
  for (std::size_t j = 0; j < space_.size(); ++j) {
    relative_steps.push_back(individuals[best].s[j] / space_.parameters()[j].step);
  }
  const double best_before = strategy_.state().best.fitness;
  if (!(best_before <= fitness[best])) state_.best_mje = best_mje;
  strategy_.tell(fitness);

  record.generation = strategy_.state().generation;
  record.best = fitness[best];
  record.median = median(valid);
  record.best_so_far = strategy_.state().best.fitness;
  const auto [smallest, largest] = std::minmax_element(relative_steps.begin(), relative_steps.end());
  record.sigma_min = *smallest;
  record.sigma_median = median(relative_steps);
  record.sigma_max = *largest;
  record.invalid = static_cast<int>(individuals.size() - valid.size());
  record.mje = state_.best_mje;
  state_.strategy = strategy_.state();
  state_.history.push_back(record);
  state_.invalid += record.invalid;
  state_.evaluations += std::ssize(outcomes);
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
  throw NumericsError(sentence + "; smaller initial steps or a longer protocol may help");
}

ArmModel Calibration::bestModel() const {
  ArmModel model = model_;
  if (!state_.strategy.best.y.empty()) space_.apply(state_.strategy.best.y, model);
  return model;
}

}  // namespace simgap
