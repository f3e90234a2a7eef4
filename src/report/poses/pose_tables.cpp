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

namespace {

constexpr const char* kPaperAngles = "  half angles of spherical joints, as 001 eq. 4";

/// Degrees per joint, two decimals.
std::vector<std::string> errorRow(std::string name, const Json& joints) {
  std::vector<std::string> row{std::move(name)};
  for (const auto& [joint, degrees] : joints.items()) row.push_back(numberText(degrees, "{:.2f}"));
  return row;
}

std::vector<std::string> errorRow(std::string name, const Json& before, const Json& after) {
  std::vector<std::string> row{std::move(name)};
  for (const auto& [joint, degrees] : after.items()) {
    row.insert(row.end(), {numberText(before.at(joint), "{:.2f}"), numberText(degrees, "{:.2f}")});
  }
  return row;
}

}  // namespace

Table calibrationErrors(const Json& result) {
  const Json &sets = result.at("mje_deg"), &paper = result.at("paper_mje_deg");
  Table table{"Mean joint errors [deg]", {"mean joint error [deg]"}, {}};
  for (const auto& [joint, degrees] : sets.at("calibration").at("final").items()) {
    table.header.insert(table.header.end(), {joint + " before", "after"});
  }
  for (const auto& [set, errors] : sets.items()) {
    const long poses = result.at("valid_poses").at(set).at("of");
    table.rows.push_back(errorRow(fmt::format("{} ({} poses)", set, poses), errors.at("initial"), errors.at("final")));
    table.rows.push_back(errorRow(kPaperAngles, paper.at(set).at("initial"), paper.at(set).at("final")));
  }
  return table;
}

Table validationErrors(const Json& result) {
  Table table{"Mean joint errors [deg]", {""}, {}};
  for (const auto& [joint, degrees] : result.at("mje_deg").items()) table.header.push_back(joint);
  const long poses = result.at("valid_poses");
  table.rows = {errorRow(fmt::format("mean joint error [deg], {} poses", poses), result.at("mje_deg")),
                errorRow(kPaperAngles, result.at("paper_mje_deg"))};
  return table;
}

}  // namespace simgap
