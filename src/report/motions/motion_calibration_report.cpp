#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "motion_tables.h"
#include "simgap/core/csv.h"
#include "simgap/core/json_numbers.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap {
namespace {

Json parametersJson(const MotionCalibrationResult& result) {
  Json parameters = Json::array();
  for (const MotionParameter& p : result.parameters) {
    parameters.push_back({{"name", p.name},
                          {"unit", p.unit},
                          {"initial", p.initial},
                          {"value", p.value},
                          {"sd", numberOrNull(p.sd)},
                          {"ci95", {numberOrNull(p.value - 1.96 * p.sd), numberOrNull(p.value + 1.96 * p.sd)}},
                          {"prior_sd", numberOrNull(p.prior_sd.value_or(NAN))},
                          {"shift_sd", numberOrNull(p.shift)},
                          {"lower", numberOrNull(p.lower)},
                          {"upper", numberOrNull(p.upper)},
                          {"at_bound", p.value <= p.lower || p.value >= p.upper},
                          {"identifiable", toString(p.verdict)}});
  }
  return parameters;
}

bool usesDescent(const MotionCalibrationResult& result) { return result.config.optimizer == "lm"; }

long rolloutsOf(const MotionCalibrationResult& result) {
  const auto& history = result.state.descent.history;
  return usesDescent(result) ? (history.empty() ? 0 : history.back().rollouts) : result.state.evolution.evaluations;
}

}  // namespace

Json toJson(const MotionCalibrationResult& result) {
  Json rms = Json::object(), predicted = Json::object(), verdicts = Json::object();
  for (const MotionSetResult& set : result.sets) {
    rms[set.name] = {{"initial", rmsJson(set.initial, result.layout)}, {"final", rmsJson(set.final, result.layout)}};
    if (!set.predicted) continue;
    predicted[set.name] = {{"mean", rmsJson(*set.predicted, result.layout)},
                           {"lower", rmsJson(*set.lower, result.layout)},
                           {"upper", rmsJson(*set.upper, result.layout)}};
  }
  for (const Verdict verdict : {Verdict::kIdentifiable, Verdict::kWeak, Verdict::kNotIdentifiable}) {
    verdicts[std::string(toString(verdict))] =
        std::ranges::count(result.parameters, verdict, &MotionParameter::verdict);
  }
  const MotionRms noise{result.noise.joints, result.noise.shafts, result.noise.currents};
  Json json = {{"format", "simgap/calibrate-motions/1"},
               {"delivered", result.failure.empty() ? "calibrated" : "start"},
               {"failure", result.failure.empty() ? Json(nullptr) : Json(result.failure)},
               {"optimizer", result.config.optimizer},
               {"step_s", result.config.motions.motion.rollout.step},
               {"motion_rms", rms},
               {"noise", rmsJson(noise, result.layout)},
               {"misfit", result.misfit},
               {"objective", {{"initial", numberOrNull(result.objective_before)}, {"final", result.fit.objective}}},
               {"converged", usesDescent(result) && result.state.descent.converged},
               {"sd_from_optimum", result.fit.from_optimum},
               {"rollouts", rolloutsOf(result)},
               {"wall_s", usesDescent(result) ? result.state.descent.wall : result.state.evolution.wall},
               {"identifiability", verdicts},
               {"combinations", result.words},
               {"parameters", parametersJson(result)}};
  if (!predicted.empty()) json["predicted_motion_rms"] = predicted;
  return json;
}

std::string terminalTable(const MotionCalibrationResult& result) {
  constexpr std::size_t kMostWords = 8;
  constexpr double kFarFromOptimum = 3.0;  // [sd]
  const Json json = toJson(result);
  const Table rms = calibrationRms(json);
  const bool converged = !usesDescent(result) || result.state.descent.converged;
  std::string text;
  if (!converged) {
    text += fmt::format(
        "not converged after {} rounds: what follows is where the search was cut off, and its intervals may be far too "
        "narrow; motions: {{rounds: {}}} in --config goes on\n",
        result.config.rounds, 2 * result.config.rounds);
  }
  text += rms.caption + "\n" + alignedTable(rms);
  text += fmt::format("of {} parameters these motions tell:", result.parameters.size());
  for (const auto& [verdict, count] : json.at("identifiability").items()) {
    text += fmt::format("{} {} {}", text.ends_with(':') ? "" : ",", wholeNumber(count), verdict);
  }
  text += "\n";
  for (std::size_t i = 0; i < std::min(kMostWords, result.words.size()); ++i) text += "  " + result.words[i] + "\n";
  if (result.words.size() > kMostWords) {
    text += fmt::format("  and {} more: see report.html\n", result.words.size() - kMostWords);
  }
  const double delay = result.parameters.back().value, sd = result.parameters.back().sd;
  text += fmt::format("the capture's clock is {:.1f} +- {:.1f} ms behind the muscles'\n", 1e3 * delay, 1e3 * sd);
  if (result.misfit > 1.5) {
    text += fmt::format(
        "the residuals are {:.1f} times what noise and model leave: something is not in the model, and "
        "all intervals are wider by that\n",
        result.misfit);
  }
  if (converged && result.fit.from_optimum > kFarFromOptimum) {
    text += fmt::format(
        "the search stopped {:.1f} standard deviations from where its derivatives still lead: the intervals may be too "
        "narrow, and a calibration on poses first (--poses) brings it nearer\n",
        result.fit.from_optimum);
  }
  return text;
}

std::string motionParametersCsv(const MotionCalibrationResult& result) {
  return csvText(recordTable("parameters", parametersJson(result),
                             {"name", "unit", "initial", "prior_sd", "value", "sd", "shift_sd", "identifiable", "lower",
                              "upper", "at_bound"}));
}

std::string motionHistoryCsv(const MotionCalibrationResult& result) {
  if (!usesDescent(result)) {
    CsvWriter csv({"generation", "best", "median", "best_so_far"});
    for (const GenerationRecord& r : result.state.evolution.history) {
      csv.add(r.generation);
      for (const double value : {r.best, r.median, r.best_so_far}) std::isfinite(value) ? csv.add(value) : csv.add("");
      csv.endRow();
    }
    return csv.text();
  }
  CsvWriter csv({"round", "before", "after", "steps", "rollouts", "expected_gain", "horizon"});
  for (const MotionRound& r : result.state.descent.history) {
    csv.add(r.round)
        .add(r.before)
        .add(r.after)
        .add(r.steps)
        .add(static_cast<double>(r.rollouts))
        .add(r.expected)
        .add(r.horizon);
    csv.endRow();
  }
  return csv.text();
}

void writeMotionCalibration(const MotionCalibrationResult& result, const RunDirectory& directory) {
  directory.write("model.yaml", writeArm(result.model));
  directory.write("parameters.csv", motionParametersCsv(result));
  directory.write("history.csv", motionHistoryCsv(result));
  std::vector<PlayedSet> sets;
  for (const MotionSetResult& set : result.sets) {
    sets.push_back({set.name, "before", &set.set, &set.before});
    sets.push_back({set.name, "after", &set.set, &set.after});
  }
  directory.write("residuals.csv", residualsCsv(result.layout, sets));
}

}  // namespace simgap
