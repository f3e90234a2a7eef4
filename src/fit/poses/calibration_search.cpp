/// The optimisers of a calibration that are peers of the paper's evolution strategy.
#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/poses/calibration.h"

namespace simgap {
namespace {

class Stopwatch {
 public:
  explicit Stopwatch(double before) : before_(before) {}  ///< [s] of earlier sessions
  double seconds() const {
    return before_ + std::chrono::duration<double>(std::chrono::steady_clock::now() - start_).count();
  }

 private:
  double before_;
  std::chrono::steady_clock::time_point start_ = std::chrono::steady_clock::now();
};

}  // namespace

/// Sum of squared errors (001 eq. 3) of the model with these values; NaN when a pose is invalid.
double Calibration::judge(const std::vector<double>& values, std::vector<double>& mje) {
  space_.apply(values, offspring_.front());
  const Assessment judged = assess(
      layout_, poses_, evaluator_.evaluate({&offspring_.front(), 1}, poses_, AfterInvalid::kGoOn), config_.objective);
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
  if (record.mje.empty()) record.mje.assign(layout_.joints.size(), std::numeric_limits<double>::quiet_NaN());
  state_.history.push_back(std::move(record));
}

/// What CMA-ES is told of an individual: `invalid` when a pose is not steady, or after an interrupt.
double Calibration::tell(const std::vector<double>& values, double invalid) {
  const std::size_t individual = static_cast<std::size_t>(state_.evaluations) / poses_.size();
  if (individual == state_.told.size()) {
    std::vector<double> mje;
    const double fitness = judge(values, mje);
    if (interruptRequested()) return invalid;  // of no meaning: not all poses were looked at
    state_.told.push_back(std::isnan(fitness) ? invalid : fitness);
  }
  state_.evaluations += std::ssize(poses_);
  state_.invalid += state_.told[individual] == invalid;
  return state_.told[individual];
}

/// A row of history.csv.
void Calibration::noteBestOf(const CmaEsGeneration& generation, const std::vector<double>& values, double invalid) {
  if (generation.best_objective == invalid) throw NumericsError("cma-es: no individual with steady poses was found");
  const EvolutionStrategyState& strategy = state_.strategy;
  const bool is_best = strategy.best.y.empty() || generation.best_objective < strategy.best.fitness;
  GenerationRecord record;
  if (is_best) judge(values, record.mje);
  if (interruptRequested()) throw InterruptedError("interrupted");
  record.median = upperMedian(generation.objectives);
  note(std::move(record), values, is_best, generation.best_objective);
}

void Calibration::runCmaEs(const AfterGeneration& after_generation) {
  const Stopwatch stopwatch(state_.wall);
  const ScaledParameters scaled(space_);
  // Finite, and worse than any arm whose poses are all steady: a joint is at most pi from where it should be, a slide
  // some metres.
  const bool slides =
      std::ranges::any_of(layout_.joints, [](const JointChannel& joint) { return kindOf(joint.type).slides; });
  const double invalid = (slides ? 1e4 : 10.0) * static_cast<double>(poses_.size() * layout_.joints.size());
  const auto values = [&](const std::vector<double>& z) {
    return scaled.values(Eigen::Map<const Eigen::VectorXd>(z.data(), std::ssize(z)));
  };
  const auto objective = [&](const std::vector<double>& z) {
    return interruptRequested() ? invalid : tell(values(z), invalid);
  };
  const CmaEsOptions options{config_.strategy.lambda, config_.strategy.generations, kHybridStep, config_.strategy.seed};
  minimiseByCmaEs(objective, space_.size(), options, [&](const CmaEsGeneration& generation) {
    if (interruptRequested()) throw InterruptedError("interrupted");
    noteBestOf(generation, values(generation.best), invalid);
    const EvolutionStrategyState& strategy = state_.strategy;
    const bool reached = strategy.best.fitness <= config_.strategy.target_fitness;
    state_.strategy.stop = reached ? StopReason::kTargetFitness : StopReason::kNone;
    if (strategy.generation == options.generations) state_.strategy.stop = StopReason::kMaxGenerations;
    state_.wall = stopwatch.seconds();
    after_generation(state_);
    return state_.strategy.stop != StopReason::kNone;
  });
}

void Calibration::searchPosterior(const AfterGeneration& after_generation) {
  const Stopwatch stopwatch(state_.wall);
  PosePosterior posterior(model_, poses_, space_, config_.noise);
  const PosteriorSearchOptions options{config_.starts, threads_, config_.strategy.seed, /*on_ranks=*/true};
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
    simgap::searchPosterior(posterior, options, state_.journal, after_fit);
  } else {
    searchHybrid(posterior, options, config_.strategy, state_.journal, after_fit);
  }
  if (interruptRequested()) throw InterruptedError("interrupted");
  if (std::isinf(best)) failWithoutEquilibrium(posterior);
  state_.strategy.stop = state_.strategy.best.fitness <= config_.strategy.target_fitness ? StopReason::kTargetFitness
                                                                                         : StopReason::kConverged;
}

void Calibration::failWithoutEquilibrium(PosePosterior& posterior) const {
  const std::vector<PoseResidual>& residuals = posterior.evaluate(Eigen::VectorXd::Zero(space_.size()), false);
  constexpr int kMostNamed = 5;
  int named = 0;
  std::string poses;
  for (std::size_t p = 0; p < residuals.size(); ++p) {
    if (residuals[p].valid) continue;
    poses += (poses.empty() ? "; the arm as it was measured has none for pose " : ", ") + poses_[p].name;
    if (++named == kMostNamed) break;
  }
  throw NumericsError("no start led to parameters with which every pose has a stable equilibrium" + poses +
                      "; attachments, line lengths or shafts may be wrong there, and --optimizer es simulates instead");
}

}  // namespace simgap
