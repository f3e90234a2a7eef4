/// \file
/// Calibration of an arm on recorded motions, from its inputs to its judged result.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/motions/motion_search.h"
#include "simgap/fit/poses/calibration.h"
#include "simgap/fit/poses/pose_uncertainty.h"

namespace simgap {

/// `simgap/calibration/1` with a `motions:` block.
struct MotionCalibrationConfig {
  std::vector<ParameterSpace::Choice> parameters;
  EvolutionStrategyOptions strategy;  ///< of es and cma-es
  std::string optimizer = "lm";       ///< "es", "cma-es"
  int rounds = 30;                    ///< of lm, at most; it ends where nothing is gained
  PoseNoise pose_noise;               ///< of --poses
  MotionPosterior::Options motions;

  /// \throws ConfigError with file, line and path.
  static MotionCalibrationConfig read(const YamlNode& root);
  std::string toYaml() const;  ///< reads back as the same configuration
};

struct MotionCalibrationTask {
  ArmModel model;
  MotionCalibrationConfig config;
  MotionSet motions;
  std::optional<PoseSet> poses;
  std::optional<MotionSet> validation;
};

/// Everything that changes while it runs.
struct MotionCalibrationState {
  MotionSearchState descent;   ///< of lm
  CalibrationState evolution;  ///< of es and cma-es; their fitness is the negative log posterior
};
Json toJson(const MotionCalibrationState& state);

class MotionCalibration {
 public:
  explicit MotionCalibration(const MotionCalibrationTask& task);
  /// Goes on where a stored state ended. \throws ConfigError: it is not one of this calibration.
  void restore(const Json& state);
  /// Searches to the end. \param news  rollouts done of those of a round, or of a generation
  /// \param after_step  with the state after every round or generation, to store it
  /// \throws NumericsError, InterruptedError
  MotionFit run(const std::function<void(const MotionSearchNews&)>& news,
                const std::function<void(const MotionCalibrationState&)>& after_step);

  const MotionPosterior& posterior() const { return posterior_; }
  const MotionCalibrationState& state() const { return state_; }

 private:
  using AfterStep = std::function<void(const MotionCalibrationState&)>;
  Eigen::VectorXd runEvolutionStrategy(const std::function<void(const MotionSearchNews&)>& news,
                                       const AfterStep& after_step);
  Eigen::VectorXd runCmaEs(const AfterStep& after_step);

  const MotionCalibrationTask& task_;
  MotionPosterior posterior_;
  MotionCalibrationState state_;
};

/// A motion set played before and after.
struct MotionSetResult {
  std::string name;  ///< "calibration" or "validation"
  MotionSet set;
  std::vector<PlayedMotion> before, after;
  MotionRms initial, final;
  /// What was to be expected of motions that the fit has not seen; of those that it has, and where fewer than two were
  /// fitted, it says nothing.
  std::optional<MotionRms> predicted = {}, lower = {}, upper = {};  ///< median, 5 and 95 %
};

/// What is known of a parameter of the search; the last one is the capture's delay.
struct MotionParameter : SearchParameter {
  double value, sd;  ///< in the parameter's unit
  double shift;      ///< from the initial value [prior standard deviations]
  Verdict verdict;
};

struct MotionCalibrationResult {
  PoseLayout layout;
  std::vector<MotionSetResult> sets;
  std::vector<MotionParameter> parameters;
  std::vector<std::string> words;  ///< what cannot be told apart
  MotionNoise noise;
  MotionFit fit;
  double misfit = 1.0;  ///< root mean square of the whitened residuals; intervals are wider by it where it exceeds 1
  MotionCalibrationState state;
  MotionCalibrationConfig config;
  double objective_before = 0.0;
  std::string failure;  ///< why the model found is not delivered; empty: it is
  ArmModel model;       ///< delivered
};

/// Plays all sets before and after with the model found, and says what is known of it. \throws InterruptedError
MotionCalibrationResult judgeMotions(const MotionCalibrationTask& task, const MotionCalibration& calibration,
                                     MotionFit fit);

}  // namespace simgap
