/// \file
/// Calibration of an arm on recorded poses: an evolution strategy over chosen parameters, judged by an evaluator, with
/// a state after every generation from which it goes on bit-identically.
#pragma once

#include <functional>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/fit/evolution_strategy.h"
#include "simgap/fit/pose_error.h"
#include "simgap/model/parameter_space.h"
#include "simgap/simulate/evaluator.h"

namespace simgap {

/// `simgap/calibration/1`: what is searched, how, and how a pose is replayed.
struct CalibrationConfig {
  std::vector<ParameterSpace::Choice> parameters;
  EvolutionStrategyOptions strategy;
  PoseProtocol protocol;
  std::string evaluator = "bullet";
  std::string optimizer = "es";
  double capture_sd = 0.3 * kDegree;  ///< [rad] of a measured joint position; the reports' noise floor

  /// \throws ConfigError with file, line and path.
  static CalibrationConfig read(const YamlNode& root);
  std::string toYaml() const;  ///< reads back as the same configuration
};

/// One generation, a row of history.csv. Step sizes are relative to the initial ones.
struct GenerationRecord {
  int generation = 0;                                           ///< from 1
  double best = 0.0;                                            ///< fitness of its best valid individual [rad^2]
  double median = 0.0;                                          ///< of its valid individuals [rad^2]
  double best_so_far = 0.0;                                     ///< of all generations [rad^2]
  double sigma_min = 0.0, sigma_median = 0.0, sigma_max = 0.0;  ///< over parameters of the generation's best
  int invalid = 0;                                              ///< individuals
  std::vector<double> mje;                                      ///< of I_best, shape (joints) [rad]
};

/// Everything that changes while a calibration runs.
struct CalibrationState {
  EvolutionStrategyState strategy;
  std::vector<GenerationRecord> history;
  std::vector<double> best_mje;  ///< of I_best, shape (joints) [rad]
  long invalid = 0;              ///< individuals in all generations
  double wall = 0.0;             ///< [s] in all sessions
};
Json toJson(const CalibrationState& state);
/// \throws ConfigError when it is no such state.
CalibrationState calibrationStateFromJson(const Json& json);

/// The search. \param poses must outlive it.
class Calibration {
 public:
  Calibration(const ArmModel& model, std::span<const Pose> poses, const CalibrationConfig& config,
              Evaluator& evaluator);
  /// Goes on where a stored state ended.
  void restore(CalibrationState state);

  /// Runs to the end. `after_generation` is called with the state after every generation, to store and show it.
  /// \throws NumericsError when a generation has no valid individual: counts of each reason and the worst case.
  /// \throws InterruptedError when the user asked to stop; the last stored state is complete.
  void run(const std::function<void(const CalibrationState&)>& after_generation);

  const CalibrationState& state() const { return state_; }
  const ParameterSpace& space() const { return space_; }
  ArmModel bestModel() const;  ///< the model with the parameters of I_best; the given one before the first generation

 private:
  void evaluateGeneration();
  [[noreturn]] void failWithoutValidIndividual(std::span<const PoseOutcome> outcomes) const;

  ArmModel model_;
  PoseLayout layout_;
  std::span<const Pose> poses_;
  CalibrationConfig config_;
  Evaluator& evaluator_;
  ParameterSpace space_;
  EvolutionStrategy strategy_;
  CalibrationState state_;
  std::vector<ArmModel> offspring_;  ///< shape (lambda)
};

}  // namespace simgap
