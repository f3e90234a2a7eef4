#include "simgap/fit/poses/calibration_run.h"

#include <fmt/format.h>

#include <filesystem>

#include "simgap/core/error.h"
#include "simgap/core/ranks.h"
#include "simgap/fit/poses/posterior_search.h"

namespace simgap {
namespace {

constexpr const char* kStateFile = "state.json";

}  // namespace

CalibrationEvaluators::CalibrationEvaluators(const CalibrationConfig& config)
    : search(makeEvaluator(config.evaluator, config.protocol)) {
  if (config.evaluator != "bullet" && config.verify == "bullet") verify = makeEvaluator(config.verify, config.protocol);
}

std::size_t expectedSteps(const CalibrationConfig& config) {
  if (!config.usesPosterior()) return static_cast<std::size_t>(config.strategy.generations);
  const int polished = config.optimizer == "hybrid" ? kHybridRounds * config.strategy.mu : 0;
  return static_cast<std::size_t>(config.starts + polished);
}

void searchAndStore(Calibration& calibration, const RunDirectory& directory,
                    const std::function<void(const CalibrationState&)>& after_step) {
  constexpr double kStateInterval = 1.0;  // [s]: a fast search would do nothing but write
  const auto store = [&] { directory.write(kStateFile, toJson(calibration.state())); };
  double stored = calibration.state().wall;
  try {
    calibration.run([&](const CalibrationState& state) {
      if (state.wall - stored >= kStateInterval) {
        store();
        stored = state.wall;
      }
      after_step(state);
    });
  } catch (const InterruptedError&) {
    store();
    throw;
  }
  store();
}

bool restoreStored(Calibration& calibration, const RunDirectory& directory) {
  const std::filesystem::path file = directory.file(kStateFile);
  try {
    const std::string stored =
        shareFromFirstRank([&] { return std::filesystem::exists(file) ? toText(readJson(file)) : std::string(); });
    if (stored.empty()) return false;
    calibration.restore(calibrationStateFromJson(Json::parse(stored)));
  } catch (const DataError& error) {  // no measured data: a file of our own that somebody damaged
    throw ConfigError(error.what());
  }
  return true;
}

CalibrationResult judgeCalibration(const CalibrationTask& task, const Calibration& calibration,
                                   const CalibrationEvaluators& evaluators,
                                   const std::function<void(std::size_t done, std::size_t total)>& progress) {
  CalibrationResult result{
      task.model.poseLayout(), {}, calibration.space().parameters(), calibration.state(), task.config};
  const ArmModel best = calibration.bestModel();
  const auto replay = [&](Evaluator& evaluator, const ArmModel& model, const PoseSet& set) {
    return replayAll(
        evaluator, model, set,
        [&](std::size_t done) {
          if (progress) progress(done, set.poses.size());
        },
        task.config.objective);
  };
  const auto add = [&](const char* name, const PoseSet& set) {
    result.sets.push_back(
        {name, set, replay(evaluators.judge(), task.model, set), replay(evaluators.judge(), best, set)});
    if (evaluators.verify) result.sets.back().searched = replay(*evaluators.search, best, set);
  };
  add("calibration", task.poses);
  if (task.validation) add("validation", *task.validation);
  addUncertainty(task.model, calibration.space(), calibration.state().strategy.best.y, result);
  return result;
}

std::vector<std::string> calibrationWarnings(const ArmModel& best, const CalibrationResult& result) {
  std::vector<std::string> warnings;
  std::vector<PoseOutcome> all;
  for (const SetResult& set : result.sets) {
    const std::vector<PoseOutcome>& outcomes = set.final.outcomes;
    all.insert(all.end(), outcomes.begin(), outcomes.end());
    const std::string ambiguous = otherEquilibria(best, set.set, outcomes);
    if (!ambiguous.empty()) warnings.push_back(ambiguous);
  }
  if (result.state.strategy.stop == StopReason::kNoValidIndividual) {
    warnings.push_back(fmt::format(
        "generation {} had no valid individual and ended the search; the result is the best of those before "
        "it (smaller steps or a longer protocol in --config may help)",
        result.state.strategy.generation));
  }
  for (const std::string& cord : stretchedCords(all, result.layout)) warnings.push_back(cord);
  return warnings;
}

CalibrationResult expectedResult(const CalibrationTask& task) {
  const ParameterSpace space(task.model, task.config.parameters);
  PoseSet modelled{task.poses.file, {}};
  const std::vector<PoseOutcome> outcomes =
      makeEquilibriumEvaluator(0)->evaluate({&task.model, 1}, task.poses.poses, AfterInvalid::kGoOn);
  for (std::size_t p = 0; p < outcomes.size(); ++p) {
    if (outcomes[p].status != PoseStatus::kSteady) continue;
    modelled.poses.push_back(task.poses.poses[p]);
    modelled.poses.back().joints = outcomes[p].joints;
  }
  CalibrationResult expected{task.model.poseLayout(), {}, space.parameters(), {}, task.config};
  expected.sets.push_back({"calibration", modelled, {}, {}});
  std::vector<double> values;
  for (const SearchParameter& p : space.parameters()) values.push_back(p.initial);
  if (!modelled.poses.empty()) addUncertainty(task.model, space, values, expected);
  return expected;
}

}  // namespace simgap
