/// \file
/// 001 section III. It states no learning rates and cites H.-G. Beyer and H.-P. Schwefel, "Evolution strategies: a
/// comprehensive introduction", Natural Computing 1 (2002) 3-52: the extended log-normal rule with one step size per
/// parameter, tau' = c / sqrt(2 n) and tau = c / sqrt(2 sqrt(n)), c = 1 for a (10, 100) strategy. Strategies there
/// mostly recombine parents; here, as in 001, a child has one parent. A step size that has become too small by chance
/// is then never averaged with better ones: single runs pause, for tens to hundreds of generations, until it has grown
/// again.
#include "simgap/optimize/evolution_strategy.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>
#include <cstddef>
#include <string_view>
#include <utility>

#include "simgap/core/error.h"

namespace simgap {
namespace {

/// What a random number is for; the values are part of the stream and must never change.
enum RandomPurpose : std::uint32_t { kCommonMutation = 1, kParameterMutation = 2 };

/// A step of 0 or infinity could never change again. No search comes near these bounds unless it has lost its meaning.
constexpr double kSmallestStep = std::numeric_limits<double>::min();
constexpr double kLargestStep = 1e150;

template <class Value>
void requireOption(bool good, std::string_view name, Value value, std::string_view range) {
  if (!good) throw ConfigError(fmt::format("evolution strategy: {} = {} is not {}", name, value, range));
}

void validateParameters(const std::vector<ObjectParameter>& parameters) {
  if (parameters.empty()) throw ConfigError("evolution strategy: there is no parameter to search for");
  for (std::size_t j = 0; j < parameters.size(); ++j) {
    const auto& [initial, step, lower, upper] = parameters[j];
    if (!(lower <= upper)) {
      throw ConfigError(fmt::format("parameter {}: lower bound {} exceeds upper bound {}", j, lower, upper));
    }
    if (!std::isfinite(initial) || initial < lower || initial > upper) {
      throw ConfigError(fmt::format("parameter {}: initial value {} is outside [{}, {}]", j, initial, lower, upper));
    }
    if (!std::isfinite(step) || !(step > 0.0)) {
      throw ConfigError(fmt::format("parameter {}: step {} is not a finite number > 0", j, step));
    }
  }
}

/// A state comes from a file, which may belong to another problem.
void validateState(const EvolutionStrategyState& state, std::size_t n, const EvolutionStrategyOptions& options) {
  const std::size_t count = state.parents.size();
  if (state.generation < 0 || count < 1 || count > static_cast<std::size_t>(options.mu)) {
    throw ConfigError(fmt::format("stored strategy: {} parents at generation {}, expected 1 to mu = {} parents", count,
                                  state.generation, options.mu));
  }
  for (const Individual& parent : state.parents) {
    if (parent.y.size() != n || parent.s.size() != n) {
      throw ConfigError(fmt::format("stored strategy: a parent has {} parameters and {} steps, expected {} of both",
                                    parent.y.size(), parent.s.size(), n));
    }
  }
}

EvolutionStrategyState initialState(const std::vector<ObjectParameter>& parameters) {
  Individual start;
  for (const ObjectParameter& parameter : parameters) {
    start.y.push_back(parameter.initial);
    start.s.push_back(parameter.step);
  }
  EvolutionStrategyState state;
  state.parents.push_back(std::move(start));
  return state;
}

StopReason stopReason(const EvolutionStrategyState& state, const EvolutionStrategyOptions& options) {
  if (state.stop == StopReason::kNoValidIndividual) return state.stop;
  if (state.best.fitness <= options.target_fitness) return StopReason::kTargetFitness;
  if (state.generation >= options.generations) return StopReason::kMaxGenerations;
  return StopReason::kNone;
}

/// Indices of the best `mu` valid individuals, best first; of equals the one of lower index, so that the order never
/// depends on the sort.
std::vector<std::size_t> selectBest(std::span<const double> fitness, int mu) {
  std::vector<std::size_t> order;
  for (std::size_t k = 0; k < fitness.size(); ++k) {
    if (std::isfinite(fitness[k])) order.push_back(k);
  }
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return fitness[a] < fitness[b]; });
  order.resize(std::min<std::size_t>(order.size(), mu));
  return order;
}

}  // namespace

void EvolutionStrategyOptions::validate() const {
  requireOption(mu >= 1, "mu", mu, "an integer >= 1");
  requireOption(lambda >= mu, "lambda", lambda, fmt::format("an integer >= mu = {}", mu));
  requireOption(generations >= 1, "generations", generations, "an integer >= 1");
  for (const auto& [name, rate] : {std::pair{"tau", tau}, std::pair{"tau_prime", tau_prime}}) {
    if (rate) requireOption(std::isfinite(*rate) && *rate >= 0.0, name, *rate, "a finite number >= 0");
  }
  requireOption(!std::isnan(target_fitness), "target_fitness", target_fitness, "a number");
}

const char* toString(StopReason reason) {
  switch (reason) {
    case StopReason::kNone:
      return "none";
    case StopReason::kMaxGenerations:
      return "max-generations";
    case StopReason::kTargetFitness:
      return "target-fitness";
    case StopReason::kNoValidIndividual:
      return "no-valid-individual";
    case StopReason::kConverged:
      return "converged";
  }
  assert(false);
  return "";
}

EvolutionStrategy::EvolutionStrategy(const std::vector<ObjectParameter>& parameters,
                                     const EvolutionStrategyOptions& options)
    : EvolutionStrategy(parameters, options, initialState(parameters)) {}

EvolutionStrategy::EvolutionStrategy(std::vector<ObjectParameter> parameters, const EvolutionStrategyOptions& options,
                                     EvolutionStrategyState state)
    : parameters_(std::move(parameters)), options_(options), random_(options.seed), state_(std::move(state)) {
  options_.validate();
  validateParameters(parameters_);
  validateState(state_, parameters_.size(), options_);
  const double n = static_cast<double>(parameters_.size());
  tau_ = options_.tau.value_or(1.0 / std::sqrt(2.0 * std::sqrt(n)));
  tau_prime_ = options_.tau_prime.value_or(1.0 / std::sqrt(2.0 * n));
  // Judged anew, so that a finished run can go on with more generations or a lower target.
  state_.stop = stopReason(state_, options_);
}

const std::vector<Individual>& EvolutionStrategy::ask() {
  if (asked_) return offspring_;
  offspring_.resize(options_.lambda);
  const auto generation = static_cast<std::uint32_t>(state_.generation);
  for (std::size_t k = 0; k < offspring_.size(); ++k) {
    Individual& child = offspring_[k];
    child = state_.parents[k % state_.parents.size()];
    child.fitness = std::numeric_limits<double>::quiet_NaN();
    RandomCounter place{generation, static_cast<std::uint32_t>(k), 0, kCommonMutation};
    const double common = tau_prime_ * random_.normalPair(place)[0];
    place.purpose = kParameterMutation;
    for (std::size_t j = 0; j < parameters_.size(); ++j) {
      place.parameter = static_cast<std::uint32_t>(j);
      const auto [step_normal, object_normal] = random_.normalPair(place);
      // The step mutates first: the object parameter is then drawn with the very step that selection will judge by it.
      child.s[j] = std::clamp(child.s[j] * std::exp(common + tau_ * step_normal), kSmallestStep, kLargestStep);
      child.y[j] = std::clamp(child.y[j] + child.s[j] * object_normal, parameters_[j].lower, parameters_[j].upper);
    }
  }
  asked_ = true;
  return offspring_;
}

void EvolutionStrategy::tell(std::span<const double> fitness) {
  assert(fitness.size() == static_cast<std::size_t>(options_.lambda));
  assert(!stopped());
  ask();  // a resumed run may tell what was evaluated before
  asked_ = false;
  ++state_.generation;
  const std::vector<std::size_t> selected = selectBest(fitness, options_.mu);
  if (selected.empty()) {
    state_.stop = StopReason::kNoValidIndividual;
    return;
  }
  state_.parents.clear();
  for (const std::size_t k : selected) {
    state_.parents.push_back(offspring_[k]);
    state_.parents.back().fitness = fitness[k];
  }
  const Individual& champion = state_.parents.front();
  if (std::isnan(state_.best.fitness) || champion.fitness < state_.best.fitness) {
    state_.best = champion;
    state_.best_generation = state_.generation;
  }
  state_.stop = stopReason(state_, options_);
}

}  // namespace simgap
