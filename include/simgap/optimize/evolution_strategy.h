/// \file
/// The (mu, lambda) evolution strategy with self-adaptive, non-isotropic mutation of 001 section III (Beyer & Schwefel
/// 2002), as ask and tell: it knows nothing of arms.
///
///     s_j <- s_j exp(tau' N(0,1) + tau N_j(0,1)),    y_j <- clamp(y_j + s_j N_j(0,1))
///
/// tau' = 1 / sqrt(2 n), tau = 1 / sqrt(2 sqrt(n)). Comma selection: the best mu valid offspring are replicated to
/// lambda, parents die; the best individual of all generations is kept beside.
#pragma once

#include <cstdint>
#include <limits>
#include <optional>
#include <span>
#include <vector>

#include "simgap/core/random.h"

namespace simgap {

struct EvolutionStrategyOptions {
  int mu = 6;                                                        ///< parents
  int lambda = 36;                                                   ///< offspring, >= mu
  int generations = 250;                                             ///< g_max
  std::optional<double> tau;                                         ///< learning rate of each step size
  std::optional<double> tau_prime;                                   ///< learning rate common to all step sizes
  double target_fitness = -std::numeric_limits<double>::infinity();  ///< stop at or below
  std::uint64_t seed = 1;
  /// \throws ConfigError that names the option, its value and its range.
  void validate() const;
};

/// One object parameter: where its search begins and may go.
struct ObjectParameter {
  double initial;
  double step;  ///< initial standard deviation of its mutation, > 0
  double lower;
  double upper;
};

/// An individual: object parameters y, step sizes s (both shape (n)) and fitness (NaN while unknown or invalid).
struct Individual {
  std::vector<double> y;
  std::vector<double> s;
  double fitness = std::numeric_limits<double>::quiet_NaN();
};

enum class StopReason { kNone, kMaxGenerations, kTargetFitness, kNoValidIndividual, kConverged };
const char* toString(StopReason reason);

/// What has to be stored to go on bit-identically: nothing else changes between generations.
struct EvolutionStrategyState {
  int generation = 0;               ///< generations told so far
  std::vector<Individual> parents;  ///< the selected ones, 1 to mu
  Individual best;                  ///< of all generations; fitness NaN before the first valid one
  int best_generation = 0;          ///< generation (from 1) that `best` came from
  StopReason stop = StopReason::kNone;
};

class EvolutionStrategy {
 public:
  /// \throws ConfigError for bad options, or for a parameter whose initial value is outside its range, whose lower
  ///         bound exceeds the upper one or whose step is not > 0.
  EvolutionStrategy(const std::vector<ObjectParameter>& parameters, const EvolutionStrategyOptions& options);
  /// Goes on from a stored state. Whether it has stopped is judged anew by the options, so that a finished run can be
  /// given more generations.
  /// \throws ConfigError also for a state of another number of parameters, or with more than mu parents or none.
  EvolutionStrategy(std::vector<ObjectParameter> parameters, const EvolutionStrategyOptions& options,
                    EvolutionStrategyState state);

  /// The lambda offspring of the coming generation; offspring k descends from parent k modulo the number of parents.
  /// A pure function of the state.
  const std::vector<Individual>& ask();
  /// Takes the offspring's fitness, shape (lambda); a value that is not finite marks an invalid individual. With no
  /// valid one the parents stay as they were. Not to be called after the stop.
  void tell(std::span<const double> fitness);

  bool stopped() const { return state_.stop != StopReason::kNone; }
  const EvolutionStrategyState& state() const { return state_; }
  const EvolutionStrategyOptions& options() const { return options_; }

 private:
  std::vector<ObjectParameter> parameters_;
  EvolutionStrategyOptions options_;
  double tau_;
  double tau_prime_;
  CounterRandom random_;
  EvolutionStrategyState state_;
  std::vector<Individual> offspring_;
  bool asked_ = false;
};

}  // namespace simgap
