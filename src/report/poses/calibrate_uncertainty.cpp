#include "calibrate_uncertainty.h"

#include <fmt/format.h>

#include <algorithm>

#include "pose_tables.h"

namespace simgap {
namespace {

constexpr Verdict kVerdicts[] = {Verdict::kIdentifiable, Verdict::kWeak, Verdict::kNotIdentifiable};

long count(const PoseUncertainty& uncertainty, Verdict verdict) {
  return std::count_if(uncertainty.parameters.begin(), uncertainty.parameters.end(),
                       [&](const ParameterUncertainty& p) { return p.verdict == verdict; });
}

/// "shoulder 1.30 (0.90 to 1.80)  elbow …"
std::string predictionText(const PoseLayout& layout, const PredictedError& predicted) {
  std::string text;
  for (std::size_t j = 0; j < predicted.mean.size(); ++j) {
    text += fmt::format("{}{} {} ({} to {})", j ? ", " : "", layout.joints[j].name, degreesText(predicted.mean[j]),
                        degreesText(predicted.lower[j]), degreesText(predicted.upper[j]));
  }
  return text;
}

/// "p003 (12.1 sd)": calibration poses that the robust loss lets go.
std::vector<std::string> outliers(const CalibrationResult& result) {
  std::vector<std::string> names;
  const PoseSet& set = result.sets.front().set;
  for (std::size_t p = 0; p < set.poses.size(); ++p) {
    const double distance = result.uncertainty->distances[p];
    if (distance > kRobustScale) names.push_back(fmt::format("{} ({:.1f} sd)", set.poses[p].name, distance));
  }
  return names;
}

/// Errors are within the interval, or larger: the model lacks something.
std::string surprise(const CalibrationResult& result) {
  std::string text;
  for (const SetResult& set : result.sets) {
    for (std::size_t j = 0; set.predicted && j < result.layout.joints.size(); ++j) {
      if (set.final.mje.empty() || set.final.mje[j] <= set.predicted->upper[j]) continue;
      text += fmt::format("{} {} deg where at most {} was to be expected: something is not in the model\n",
                          result.layout.joints[j].name, degreesText(set.final.mje[j]),
                          degreesText(set.predicted->upper[j]));
    }
  }
  return text;
}

}  // namespace

Json uncertaintyJson(const CalibrationResult& result) {
  if (!result.uncertainty) return Json::object();
  const PoseUncertainty& uncertainty = *result.uncertainty;
  Json combinations = Json::array();
  for (const Combination& combination : uncertainty.combinations) {
    Json names = Json::array();
    for (const std::size_t i : combination.parameters) names.push_back(result.parameters[i].name);
    combinations.push_back({{"parameters", names}, {"for_any_pose", combination.always}, {"text", combination.text}});
  }
  Json verdicts = Json::object();
  for (const Verdict verdict : kVerdicts) verdicts[std::string(toString(verdict))] = count(uncertainty, verdict);
  Json predicted = {{"unseen", predictionJson(result.layout, result.predicted_unseen)}};
  for (const SetResult& set : result.sets) {
    if (set.predicted) predicted[set.name] = predictionJson(result.layout, *set.predicted);
  }
  Json outlying = Json::array();
  for (std::size_t p = 0; p < uncertainty.distances.size(); ++p) {
    if (uncertainty.distances[p] > kRobustScale) {
      outlying.push_back({{"pose", result.sets.front().set.poses[p].name}, {"distance_sd", uncertainty.distances[p]}});
    }
  }
  return {{"identifiability", verdicts},
          {"combinations", combinations},
          {"singular_values", uncertainty.singular_values},
          {"predicted_mje_deg", predicted},
          {"outlying_poses", outlying}};
}

std::string singularValuesCsv(const CalibrationResult& result) {
  CsvWriter csv({"direction", "singular_value"});
  for (std::size_t i = 0; i < result.uncertainty->singular_values.size(); ++i) {
    csv.add(static_cast<int>(i + 1)).add(result.uncertainty->singular_values[i]).endRow();
  }
  return csv.text();
}

std::string uncertaintyText(const CalibrationResult& result) {
  constexpr std::size_t kMostCombinations = 8;
  constexpr std::size_t kMostOutliers = 4;
  if (!result.uncertainty) return {};
  const PoseUncertainty& uncertainty = *result.uncertainty;
  std::string text = fmt::format("the poses tell, of {} parameters: {} identifiable, {} weak, {} not identifiable\n",
                                 result.parameters.size(), count(uncertainty, Verdict::kIdentifiable),
                                 count(uncertainty, Verdict::kWeak), count(uncertainty, Verdict::kNotIdentifiable));
  std::size_t named = 0;
  for (const Combination& combination : uncertainty.combinations) {
    if (combination.parameters.size() > 2 || named == kMostCombinations) continue;
    text += "  " + combination.text + "\n";
    ++named;
  }
  if (named < uncertainty.combinations.size()) {
    text += fmt::format("  {}{} combinations of parameters that no pose tells apart: see report.html\n",
                        named ? "and " : "", uncertainty.combinations.size() - named);
  }
  for (const SetResult& set : result.sets) {
    if (!set.predicted) continue;
    text +=
        fmt::format("predicted for the {} poses [deg]: {}\n", set.name, predictionText(result.layout, *set.predicted));
  }
  if (result.sets.size() == 1) {
    text +=
        fmt::format("predicted for unseen poses [deg]: {}\n", predictionText(result.layout, result.predicted_unseen));
  }
  text += surprise(result);
  const std::vector<std::string> far = outliers(result);
  if (far.size() > kMostOutliers) {
    text += fmt::format("{} of {} poses are more than {:g} sd from the fit\n", far.size(), uncertainty.distances.size(),
                        kRobustScale);
  } else if (!far.empty()) {
    text += fmt::format("poses far from the fit, hardly counted: {}\n", fmt::join(far, ", "));
  }
  return text;
}

Json verificationJson(const CalibrationResult& result) {
  Json sets = Json::object();
  for (const SetResult& set : result.sets) {
    if (!set.searched) continue;
    Json mean = Json::object(), largest = Json::object();
    for (std::size_t j = 0; j < result.layout.joints.size(); ++j) {
      const PoseDifference difference = poseDifference(set, result.layout, j);
      mean[result.layout.joints[j].name] = numberOrNull(toDegrees(difference.mean));
      largest[result.layout.joints[j].name] = numberOrNull(toDegrees(difference.largest));
    }
    sets[set.name] = {{"mje_deg", mjeJson(result.layout, set.searched->mje)},
                      {"difference_deg", {{"mean", mean}, {"largest", largest}}}};
  }
  if (sets.empty()) return Json::object();
  return {
      {"verification", {{"judge", result.config.verify}, {"searched_by", result.config.evaluator}, {"sets", sets}}}};
}

std::string verificationText(const CalibrationResult& result) {
  std::string text;
  for (const SetResult& set : result.sets) {
    if (!set.searched) continue;
    text += fmt::format("{} alone finds, {} poses [deg]:", result.config.evaluator, set.name);
    for (std::size_t j = 0; j < result.layout.joints.size(); ++j) {
      const PoseDifference difference = poseDifference(set, result.layout, j);
      text += fmt::format(" {} {} ({} from {}'s on average, at most {})", result.layout.joints[j].name,
                          degreesText(set.searched->mje[j]), degreesText(difference.mean), result.config.verify,
                          degreesText(difference.largest));
    }
    text += "\n";
  }
  return text;
}

}  // namespace simgap
