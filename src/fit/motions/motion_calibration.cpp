#include "simgap/fit/motions/motion_calibration.h"

#include <fmt/format.h>

#include <algorithm>
#include <chrono>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

constexpr double kEvolutionStep = 0.3;  // of every parameter, in prior standard deviations
constexpr double kInvalid = 1e12;       // what CMA-ES is told of a model whose motions cannot be played
constexpr double kDifference = 0.1;     // of derivatives behind a search without any [prior sd]

std::span<const Pose> posesOf(const MotionCalibrationTask& task) {
  return task.poses ? std::span<const Pose>(task.poses->poses) : std::span<const Pose>();
}

std::vector<ObjectParameter> searchSpace(const MotionPosterior& posterior) {
  std::vector<ObjectParameter> space;
  for (Eigen::Index i = 0; i < posterior.size(); ++i) {
    space.push_back({0.0, kEvolutionStep, posterior.lower(i), posterior.upper(i)});
  }
  return space;
}

Eigen::VectorXd vectorOf(const std::vector<double>& z) {
  return Eigen::Map<const Eigen::VectorXd>(z.data(), std::ssize(z));
}

double seconds() { return std::chrono::duration<double>(std::chrono::steady_clock::now().time_since_epoch()).count(); }

GenerationRecord recordOf(const EvolutionStrategyState& strategy, double best, double median) {
  GenerationRecord record;
  record.generation = strategy.generation;
  record.best = best;
  record.median = median;
  record.best_so_far = strategy.best.fitness;
  return record;
}

}  // namespace

Json toJson(const MotionCalibrationState& state) {
  return {{"format", "simgap/motion-calibration-state/1"},
          {"descent", toJson(state.descent)},
          {"evolution", toJson(state.evolution)}};
}

MotionCalibration::MotionCalibration(const MotionCalibrationTask& task)
    : task_(task),
      posterior_(task.model, task.motions.motions, posesOf(task), task.config.parameters, task.config.pose_noise,
                 task.config.motions) {
  state_.descent = beginSearch(posterior_);
}

void MotionCalibration::restore(const Json& state) {
  try {
    state_.descent = motionSearchStateFromJson(state.at("descent"), posterior_.size());
    state_.evolution = calibrationStateFromJson(state.at("evolution"));
  } catch (const Json::exception& error) {
    throw ConfigError(std::string("the stored state is not a simgap/motion-calibration-state/1: ") + error.what());
  }
  const auto stored = std::ssize(state_.evolution.strategy.best.y);
  if (stored != 0 && stored != posterior_.size()) {
    throw ConfigError(fmt::format("the stored state is not one of {} parameters", posterior_.size()));
  }
}

MotionFit MotionCalibration::run(const std::function<void(const MotionSearchNews&)>& news,
                                 const AfterStep& after_step) {
  if (task_.config.optimizer == "lm") {
    return searchMotions(posterior_, state_.descent, task_.config.rounds, news,
                         [&](const MotionSearchState&) { after_step(state_); });
  }
  const Eigen::VectorXd z =
      task_.config.optimizer == "es" ? runEvolutionStrategy(news, after_step) : runCmaEs(after_step);
  return fitAt(posterior_, z, Eigen::VectorXd::Constant(posterior_.size(), kDifference), news);
}

Eigen::VectorXd MotionCalibration::runEvolutionStrategy(const std::function<void(const MotionSearchNews&)>& news,
                                                        const AfterStep& after_step) {
  CalibrationState& state = state_.evolution;
  EvolutionStrategy strategy = state.strategy.parents.empty()
                                   ? EvolutionStrategy(searchSpace(posterior_), task_.config.strategy)
                                   : EvolutionStrategy(searchSpace(posterior_), task_.config.strategy, state.strategy);
  while (!strategy.stopped()) {
    const double start = seconds();
    std::vector<Eigen::VectorXd> z;
    for (const Individual& individual : strategy.ask()) z.push_back(vectorOf(individual.y));
    const std::vector<double> objectives = posterior_.objectives(z);
    if (interruptRequested()) throw InterruptedError("interrupted");
    strategy.tell(objectives);
    if (!std::isfinite(strategy.state().best.fitness)) {
      throw NumericsError("no individual's motions could be played; smaller steps or a smaller step_s may help");
    }
    state.strategy = strategy.state();
    state.history.push_back(recordOf(state.strategy, *std::ranges::min_element(objectives), median(objectives)));
    state.evaluations += std::ssize(z) * std::ssize(posterior_.motions());
    state.wall += seconds() - start;
    if (news) news({static_cast<std::size_t>(state.strategy.generation), 0});
    after_step(state_);
  }
  return vectorOf(strategy.state().best.y);
}

Eigen::VectorXd MotionCalibration::runCmaEs(const AfterStep& after_step) {
  CalibrationState& state = state_.evolution;
  CalibrationState begun;  // it passes again through what it was told, which costs next to nothing
  begun.told = std::move(state.told);
  begun.wall = state.wall;
  state = std::move(begun);
  const double start = seconds() - state.wall;
  const EvolutionStrategyOptions& options = task_.config.strategy;
  std::size_t individual = 0;
  const auto objective = [&](const std::vector<double>& y) {
    if (interruptRequested()) return kInvalid;
    if (individual++ < state.told.size()) return state.told[individual - 1];
    Eigen::VectorXd z = vectorOf(y);
    for (Eigen::Index i = 0; i < z.size(); ++i) z[i] = std::clamp(z[i], posterior_.lower(i), posterior_.upper(i));
    const double found = posterior_.objectives({&z, 1}).front();
    if (interruptRequested()) return kInvalid;
    state.told.push_back(std::isfinite(found) ? found : kInvalid);
    return state.told.back();
  };
  const CmaEsOptions cma{options.lambda, options.generations, kEvolutionStep, options.seed};
  minimiseByCmaEs(objective, static_cast<std::size_t>(posterior_.size()), cma, [&](const CmaEsGeneration& generation) {
    if (interruptRequested()) throw InterruptedError("interrupted");
    ++state.strategy.generation;
    Individual& best = state.strategy.best;
    if (!(best.fitness <= generation.best_objective)) {
      best = {generation.best, {}, generation.best_objective};
      for (std::size_t i = 0; i < best.y.size(); ++i) {
        const auto k = static_cast<Eigen::Index>(i);
        best.y[i] = std::clamp(best.y[i], posterior_.lower(k), posterior_.upper(k));
      }
      state.strategy.best_generation = state.strategy.generation;
    }
    state.history.push_back(recordOf(state.strategy, generation.best_objective, upperMedian(generation.objectives)));
    state.evaluations = static_cast<long>(individual) * std::ssize(posterior_.motions());
    state.wall = seconds() - start;
    after_step(state_);
    return best.fitness <= options.target_fitness;
  });
  if (state.strategy.best.fitness >= kInvalid) throw NumericsError("no individual's motions could be played");
  return vectorOf(state.strategy.best.y);
}

}  // namespace simgap
