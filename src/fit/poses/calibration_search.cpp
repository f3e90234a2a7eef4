/// The optimisers of a calibration that are peers of the paper's evolution strategy.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/poses/calibration.h"
#include "simgap/fit/poses/pose_posterior.h"
#include "simgap/fit/poses/posterior_search.h"
#include "simgap/optimize/cma_es.h"

namespace simgap {
namespace {

class Stopwatch {
 public:
  double seconds() const { return std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count(); }

 private:
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

/// Sum of squared errors (001 eq. 3) of the model with these values; NaN when a pose is invalid.
double Calibration::judge(const std::vector<double>& values, std::vector<double>& mje) {
  space_.apply(values, offspring_.front());
  const Assessment judged =
      assess(layout_, poses_, evaluator_.evaluate({&offspring_.front(), 1}, poses_, AfterInvalid::kGoOn));
  mje = judged.mje;
  return judged.fitness;
}

void Calibration::note(GenerationRecord record, const std::vector<double>& values, bool is_best, double fitness) {
  EvolutionStrategyState& strategy = state_.strategy;
  record.generation = ++strategy.generation;
  if (is_best) {
    strategy.best = {values, {}, fitness};
    strategy.best_generation = record.generation;
    state_.best_mje = record.mje;
  }
  record.best = fitness;
  record.best_so_far = strategy.best.fitness;
  record.mje = state_.best_mje;
  state_.history.push_back(std::move(record));
}

void Calibration::runCmaEs(const AfterGeneration& after_generation) {
  const Stopwatch stopwatch;
  const ScaledParameters scaled(space_);
  // Finite, and worse than any arm whose poses are all steady: a joint is at most pi from where it should be.
  const double invalid = 10.0 * static_cast<double>(poses_.size() * layout_.joints.size());
  std::vector<double> mje;
  const auto values = [&](const std::vector<double>& z) {
    return scaled.values(Eigen::Map<const Eigen::VectorXd>(z.data(), std::ssize(z)));
  };
  const auto objective = [&](const std::vector<double>& z) {
    if (interruptRequested()) return invalid;
    const double fitness = judge(values(z), mje);
    state_.evaluations += std::ssize(poses_);
    state_.invalid += std::isnan(fitness);
    return std::isnan(fitness) ? invalid : fitness;
  };
  const CmaEsOptions options{config_.strategy.lambda, config_.strategy.generations, kHybridStep, config_.strategy.seed};
  minimiseByCmaEs(objective, space_.size(), options, [&](const CmaEsGeneration& generation) {
    if (interruptRequested()) throw InterruptedError("interrupted");
    GenerationRecord record;
    const std::vector<double> best = values(generation.best);
    const double fitness = judge(best, record.mje);
    if (std::isnan(fitness)) throw NumericsError("cma-es: no individual with steady poses was found");
    record.median = upperMedian(generation.objectives);
    const EvolutionStrategyState& strategy = state_.strategy;
    note(std::move(record), best, strategy.best.y.empty() || fitness < strategy.best.fitness, fitness);
    state_.strategy.stop = fitness <= config_.strategy.target_fitness ? StopReason::kTargetFitness : StopReason::kNone;
    if (strategy.generation == options.generations) state_.strategy.stop = StopReason::kMaxGenerations;
    state_.wall = stopwatch.seconds();
    after_generation(state_);
    return state_.strategy.stop != StopReason::kNone;
  });
}

void Calibration::searchPosterior(const AfterGeneration& after_generation) {
  const Stopwatch stopwatch;
  PosePosterior posterior(model_, poses_, space_, config_.noise);
  const PosteriorSearchOptions options{config_.starts, threads_, config_.strategy.seed};
  double best = std::numeric_limits<double>::infinity();
  const auto after_fit = [&](const PosteriorFit& fit) {
    state_.evaluations += fit.evaluations;
    if (std::isinf(fit.objective)) ++state_.invalid;
    GenerationRecord record;
    const std::vector<double> values = posterior.parameters().values(fit.z);
    const double fitness = judge(values, record.mje);
    record.median = fitness;
    // The posterior decides, not the fitness: with more parameters than measured numbers the smallest error is not the
    // best model.
    const bool is_best = fit.objective < best;
    if (is_best) best = fit.objective;
    note(std::move(record), values, is_best, fitness);
    state_.wall = stopwatch.seconds();
    after_generation(state_);
    return state_.strategy.best.fitness <= config_.strategy.target_fitness;
  };
  if (config_.optimizer == "lm") {
    simgap::searchPosterior(posterior, options, after_fit);
  } else {
    searchHybrid(posterior, options, config_.strategy, after_fit);
  }
  if (interruptRequested()) throw InterruptedError("interrupted");
  if (std::isinf(best)) {
    throw NumericsError("no start led to parameters with which every pose has a stable equilibrium");
  }
  state_.strategy.stop = state_.strategy.best.fitness <= config_.strategy.target_fitness ? StopReason::kTargetFitness
                                                                                         : StopReason::kConverged;
}

}  // namespace simgap
