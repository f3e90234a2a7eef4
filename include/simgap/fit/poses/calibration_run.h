/// \file
/// A calibration from its inputs to its judged result: search, store so that it can be resumed, judge.
#pragma once

#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/poses/calibration_result.h"
#include "simgap/simulate/replay.h"

namespace simgap {

/// Everything a calibration starts from.
struct CalibrationTask {
  ArmModel model;
  CalibrationConfig config;
  PoseSet poses;
  std::optional<PoseSet> validation;
};

/// The evaluators of a calibration: one searches, one judges what was found.
struct CalibrationEvaluators {
  explicit CalibrationEvaluators(const CalibrationConfig& config);
  Evaluator& judge() const { return verify ? *verify : *search; }

  std::unique_ptr<Evaluator> search;
  std::unique_ptr<Evaluator> verify;  ///< null: the one that searches judges, too
};

/// Generations, or descents of lm and hybrid.
std::size_t expectedSteps(const CalibrationConfig& config);

/// Searches to the end; writes state.json into the directory about once a second and at the end.
/// \param after_step  called with the state after every generation or descent. \throws as Calibration::run; the stored
///        state is then complete.
void searchAndStore(Calibration& calibration, const RunDirectory& directory,
                    const std::function<void(const CalibrationState&)>& after_step);

/// Goes on where the directory's stored state ended. \returns false without one: the run was stopped in its first
/// generation. \throws ConfigError: a file that is no such state.
bool restoreStored(Calibration& calibration, const RunDirectory& directory);

/// Replays all sets before and after, by both evaluators, and adds what is known of the parameters.
/// \param progress  called with the number of poses done of a replay of `total`. \throws InterruptedError
CalibrationResult judgeCalibration(const CalibrationTask& task, const Calibration& calibration,
                                   const CalibrationEvaluators& evaluators,
                                   const std::function<void(std::size_t done, std::size_t total)>& progress = {});

/// What to know before believing the result: other equilibria, cords beyond their linear range. \param best  the
/// calibrated model
std::vector<std::string> calibrationWarnings(const ArmModel& best, const CalibrationResult& result);

/// What the poses will tell of the parameters, before any search: at the poses where the model itself would rest.
CalibrationResult expectedResult(const CalibrationTask& task);

}  // namespace simgap
