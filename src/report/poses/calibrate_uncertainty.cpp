#include "calibrate_uncertainty.h"

#include <fmt/format.h>

#include <algorithm>

#include "pose_tables.h"
#include "simgap/core/json_numbers.h"

namespace simgap {
namespace {

constexpr Verdict kVerdicts[] = {Verdict::kIdentifiable, Verdict::kWeak, Verdict::kNotIdentifiable};

long count(const PoseUncertainty& uncertainty, Verdict verdict) {
  return std::count_if(uncertainty.parameters.begin(), uncertainty.parameters.end(),
                       [&](const ParameterUncertainty& p) { return p.verdict == verdict; });
}

}  // namespace

Json uncertaintyJson(const CalibrationResult& result) {
  Json known = {{"converged", result.from_optimum <= kAtOptimum},
                {"sd_from_optimum", numberOrNull(result.from_optimum)}};
  if (!result.uncertainty) return known;
  const PoseUncertainty& uncertainty = *result.uncertainty;
  Json combinations = Json::array();
  for (const Combination& combination : uncertainty.combinations) {
    Json names = Json::array();
    for (const std::size_t i : combination.parameters) names.push_back(result.parameters[i].name);
    combinations.push_back({{"parameters", names}, {"for_any_pose", combination.always}, {"text", combination.text}});
  }
  Json verdicts = Json::object();
  for (const Verdict verdict : kVerdicts) verdicts[std::string(toString(verdict))] = count(uncertainty, verdict);
  Json predicted = Json::object();
  for (const std::string& unit : errorUnits(result.layout)) {
    Json sets = Json::object();
    const auto add = [&](const std::string& name, const PredictedError& error) {
      if (!error.mean.empty()) sets[name] = predictionJson(result.layout, error, unit);
    };
    add("unseen", result.predicted_unseen);
    for (const SetResult& set : result.sets) {
      if (set.predicted) add(set.name, *set.predicted);
    }
    if (!sets.empty()) predicted["predicted_mje_" + unit] = sets;
  }
  Json outlying = Json::array();
  for (std::size_t p = 0; p < uncertainty.distances.size(); ++p) {
    if (uncertainty.distances[p] > kRobustScale) {
      outlying.push_back({{"pose", result.sets.front().set.poses[p].name}, {"distance_sd", uncertainty.distances[p]}});
    }
  }
  known.update({{"identifiability", verdicts},
                {"combinations", combinations},
                {"singular_values", uncertainty.singular_values},
                {"outlying_poses", outlying}});
  known.update(predicted);
  return known;
}

std::string singularValuesCsv(const CalibrationResult& result) {
  CsvWriter csv({"direction", "singular_value"});
  for (std::size_t i = 0; i < result.uncertainty->singular_values.size(); ++i) {
    csv.add(static_cast<int>(i + 1)).add(result.uncertainty->singular_values[i]).endRow();
  }
  return csv.text();
}

std::string uncertaintyText(const Json& json) {
  constexpr std::size_t kMostCombinations = 8;
  if (!json.contains("identifiability")) return {};
  long all = 0;
  for (const Json& parameters : json.at("identifiability")) all += wholeNumber(parameters);
  std::string text = fmt::format("the poses tell, of {} parameters:", all);
  for (const auto& [verdict, parameters] : json.at("identifiability").items()) {
    text += fmt::format("{} {} {}", text.ends_with(':') ? "" : ",", wholeNumber(parameters), verdict);
  }
  text += "\n";
  std::size_t named = 0;
  for (const Json& combination : json.at("combinations")) {
    if (combination.at("parameters").size() > 2 || named == kMostCombinations) continue;
    text += "  " + combination.at("text").get<std::string>() + "\n";
    ++named;
  }
  if (named < json.at("combinations").size()) {
    text += fmt::format("  {}{} combinations of parameters that no pose tells apart: see report.html\n",
                        named ? "and " : "", json.at("combinations").size() - named);
  }
  if (!json.contains("predicted_mje_deg")) return text;  // no command that the arm can take was drawn
  const Table predicted = predictionTable(json);
  return text + predicted.caption + "\n" + alignedTable(predicted);
}

Json verificationJson(const CalibrationResult& result) {
  Json sets = Json::object();
  for (const SetResult& set : result.sets) {
    if (!set.searched) continue;
    std::vector<double> mean, largest;
    for (std::size_t j = 0; j < result.layout.joints.size(); ++j) {
      const PoseDifference difference = poseDifference(set, result.layout, j);
      mean.push_back(difference.mean);
      largest.push_back(difference.largest);
    }
    for (const std::string& unit : errorUnits(result.layout)) {
      sets[set.name]["mje_" + unit] = mjeJson(result.layout, set.searched->mje, unit);
      sets[set.name]["difference_" + unit] = {{"mean", mjeJson(result.layout, mean, unit)},
                                              {"largest", mjeJson(result.layout, largest, unit)}};
    }
  }
  if (sets.empty()) return Json::object();
  return {
      {"verification", {{"judge", result.config.verify}, {"searched_by", result.config.evaluator}, {"sets", sets}}}};
}

}  // namespace simgap
