#include <fmt/format.h>

#include "calibrate_uncertainty.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/report/poses/pose_report.h"
#include "simgap/simulate/arm_geometry.h"

namespace simgap {

std::string planText(const CalibrationTask& task, const CalibrationResult& expected) {
  const CalibrationConfig& config = task.config;
  std::string text = fmt::format("would search {} parameters on {} poses with {} by {}", expected.parameters.size(),
                                 task.poses.poses.size(), config.evaluator, config.optimizer);
  if (config.usesPosterior()) {
    text += fmt::format(", {} starts\n", config.starts);
  } else {
    const EvolutionStrategyOptions& strategy = config.strategy;
    text += fmt::format(": {} generations of {} individuals ({} parents), {} pose simulations\n", strategy.generations,
                        strategy.lambda, strategy.mu,
                        static_cast<long>(strategy.generations) * strategy.lambda * std::ssize(task.poses.poses));
  }
  for (const ParameterSpace::Choice& choice : config.parameters) {
    text += fmt::format("  {}, initial step {}\n", choice.pattern, choice.step);
  }
  return text + uncertaintyText(uncertaintyJson(expected)) + "nothing was written\n";
}

void writeCalibration(const ArmModel& before, const ArmModel& after, const CalibrationResult& result,
                      const RunDirectory& directory) {
  directory.write("model.yaml", writeArm(judgeDelivery(result).calibrated ? after : before));
  directory.write("history.csv", historyCsv(result));
  directory.write("parameters.csv", parametersCsv(result));
  directory.write("errors.csv", errorsCsv(result));
  if (result.uncertainty) directory.write("singular_values.csv", singularValuesCsv(result));
  std::vector<ReplayedSet> replays;
  for (const SetResult& set : result.sets) {
    replays.push_back({set.name, "before", before, set.set, set.initial.outcomes});
    replays.push_back({set.name, "after", after, set.set, set.final.outcomes});
  }
  writeArmGeometry(replays, directory);
}

}  // namespace simgap
