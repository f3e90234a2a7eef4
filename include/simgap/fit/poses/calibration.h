/// \file
/// Calibration of an arm on recorded poses: an optimiser over chosen parameters. Each keeps a state from which it goes
/// on bit-identically: the evolution strategy its parents, CMA-ES what it was told, the descents those that are
/// finished.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/fit/poses/pose_noise.h"
#include "simgap/fit/poses/posterior_search.h"
#include "simgap/model/arm/parameter_space.h"
#include "simgap/optimize/cma_es.h"
#include "simgap/optimize/evolution_strategy.h"
#include "simgap/simulate/evaluator.h"
#include "simgap/simulate/pose_error.h"

namespace simgap {

/// `simgap/calibration/1`: what is searched, how, and how a pose is replayed.
struct CalibrationConfig {
  std::vector<ParameterSpace::Choice> parameters;
  EvolutionStrategyOptions strategy;
  PoseProtocol protocol;
  std::string evaluator = "bullet";  ///< or "equilibrium"; what es and cma-es search with
  std::string optimizer = "lm";      ///< "hybrid", "es", "cma-es"; the first two search with equilibria always
  PoseObjective objective = PoseObjective::kGeodesic;  ///< what es and cma-es minimise
  std::string verify = "bullet";  ///< who judges the model that was found; "none": the evaluator itself
  int starts = 8;                 ///< of lm and hybrid
  std::string only_poses = "*";   ///< the search sees those of this name (a glob), the poses of a sub-task
  PoseNoise noise;                ///< of the recorded poses; `capture_sd` is the reports' noise floor

  bool usesPosterior() const { return optimizer == "lm" || optimizer == "hybrid"; }
  /// \throws ConfigError with file, line and path.
  static CalibrationConfig read(const YamlNode& root);
  std::string toYaml() const;  ///< reads back as the same configuration
};

/// One generation (of lm and hybrid: one descent), a row of history.csv. Step sizes are relative to the initial ones;
/// 0: the optimiser has none.
struct GenerationRecord {
  int generation = 0;                                           ///< from 1
  double best = 0.0;                                            ///< fitness of its best valid individual [rad^2];
                                                                ///< NaN: none
  double median = 0.0;                                          ///< of its valid individuals [rad^2]
  double best_so_far = 0.0;                                     ///< of all generations [rad^2]
  double sigma_min = 0.0, sigma_median = 0.0, sigma_max = 0.0;  ///< over parameters of the generation's best
  int invalid = 0;                                              ///< individuals
  std::vector<double> mje;                                      ///< of I_best, shape (joints) [rad]; NaN: none yet
};

/// Everything that changes while a calibration runs.
struct CalibrationState {
  EvolutionStrategyState strategy;
  std::vector<GenerationRecord> history;
  std::vector<double> told;      ///< cma-es: objective of every individual in its order
  SearchJournal journal;         ///< of lm and hybrid
  std::vector<double> best_mje;  ///< of I_best, shape (joints) [rad]
  long invalid = 0;              ///< individuals in all generations
  long evaluations = 0;          ///< poses that were simulated or solved
  double wall = 0.0;             ///< [s] in all sessions
};
Json toJson(const CalibrationState& state);
/// \throws ConfigError when it is no such state.
CalibrationState calibrationStateFromJson(const Json& json);

/// The search. \param poses must outlive it.
class Calibration {
 public:
  /// \param threads  of the optimisers that do not use the evaluator; 0: all
  Calibration(const ArmModel& model, std::span<const Pose> poses, const CalibrationConfig& config, Evaluator& evaluator,
              int threads = 0);
  /// Goes on where a stored state ended. \throws ConfigError: it is not one of this calibration.
  void restore(CalibrationState state);

  /// Searches to the end. `after_generation` is called with the state after every generation, to store and show it.
  /// A generation without a valid individual ends it with the best of those before, as 001 does.
  /// \throws NumericsError when there was none before: counts of each reason and the worst case.
  /// \throws InterruptedError when the user asked to stop; the last stored state is complete.
  void run(const std::function<void(const CalibrationState&)>& after_generation);

  const CalibrationState& state() const { return state_; }
  const ParameterSpace& space() const { return space_; }
  ArmModel bestModel() const;  ///< the model with the parameters of I_best; the given one before the first generation

 private:
  void evaluateGeneration();
  void noteSteps(const Individual& individual, GenerationRecord& record) const;
  using AfterGeneration = std::function<void(const CalibrationState&)>;
  void runEvolutionStrategy(const AfterGeneration& after_generation);
  void runCmaEs(const AfterGeneration& after_generation);
  void searchPosterior(const AfterGeneration& after_generation);
  double judge(const std::vector<double>& values, std::vector<double>& mje);
  double tell(const std::vector<double>& values, double invalid);
  void noteBestOf(const CmaEsGeneration& generation, const std::vector<double>& values, double invalid);
  [[noreturn]] void failWithoutEquilibrium(PosePosterior& posterior) const;
  void note(GenerationRecord record, const std::vector<double>& values, bool is_best, double fitness);
  [[noreturn]] void failWithoutValidIndividual(std::span<const PoseOutcome> outcomes) const;

  ArmModel model_;
  PoseLayout layout_;
  std::span<const Pose> poses_;
  CalibrationConfig config_;
  Evaluator& evaluator_;
  int threads_;
  ParameterSpace space_;
  EvolutionStrategy strategy_;
  CalibrationState state_;
  std::vector<ArmModel> offspring_;  ///< shape (lambda)
};

}  // namespace simgap
