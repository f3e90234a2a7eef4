#include "pose_tables.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

namespace simgap {

Json mjeJson(const PoseLayout& layout, const std::vector<double>& mje) {
  Json json = Json::object();
  for (std::size_t j = 0; j < layout.joints.size(); ++j) json[layout.joints[j].name] = numberOrNull(toDegrees(mje[j]));
  return json;
}

Json predictionJson(const PoseLayout& layout, const PredictedError& predicted) {
  Json json = Json::object();
  for (std::size_t j = 0; j < predicted.mean.size(); ++j) {
    json[layout.joints[j].name] = {{"mean", toDegrees(predicted.mean[j])},
                                   {"ci90", {toDegrees(predicted.lower[j]), toDegrees(predicted.upper[j])}}};
  }
  return json;
}

std::vector<double> paperAngles(const PoseLayout& layout, std::vector<double> angles) {
  for (std::size_t j = 0; j < angles.size(); ++j) {
    if (layout.joints[j].type == JointType::kSpherical) angles[j] *= 0.5;
  }
  return angles;
}

std::vector<std::string> slackMuscles(const PoseOutcome& outcome, const PoseLayout& layout) {
  std::vector<std::string> slack;
  for (std::size_t m = 0; m < outcome.cord_expansion.size(); ++m) {
    if (outcome.cord_expansion[m] <= 0.0) slack.push_back(layout.muscles[m]);
  }
  return slack;
}

std::string slackText(const PoseOutcome& outcome, const PoseLayout& layout) {
  return fmt::format("{}", fmt::join(slackMuscles(outcome, layout), " "));
}

std::vector<std::string> invalidPoses(const Assessment& assessment, const PoseSet& set, const PoseLayout& layout) {
  std::vector<std::string> lines;
  for (std::size_t p = 0; p < set.poses.size(); ++p) {
    if (assessment.outcomes[p].status == PoseStatus::kSteady) continue;
    lines.push_back(fmt::format("{}: {}", set.poses[p].name, describe(assessment.outcomes[p], layout)));
  }
  return lines;
}

}  // namespace simgap
