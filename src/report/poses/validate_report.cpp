#include <fmt/format.h>

#include <algorithm>

#include "pose_page.h"
#include "pose_tables.h"
#include "simgap/core/joint_kind.h"

namespace simgap {

Json toJson(const ValidationResult& result) {
  const Assessment& judged = result.assessment;
  Json poses = Json::array();
  for (std::size_t p = 0; p < result.set.poses.size(); ++p) {
    const bool steady = !judged.errors[p].empty();
    Json pose = {{"pose", result.set.poses[p].name}, {"status", toString(judged.outcomes[p].status)}};
    for (const std::string& unit : errorUnits(result.layout)) {
      pose["error_" + unit] = steady ? mjeJson(result.layout, judged.errors[p], unit) : Json(nullptr);
    }
    pose["slack"] = slackMuscles(judged.outcomes[p], result.layout);
    poses.push_back(std::move(pose));
  }
  Json criteria = Json::array();
  for (const Criterion& c : result.criteria) {
    criteria.push_back({{"name", c.name}, {"limit", c.limit}, {"value", numberOrNull(c.value)}, {"pass", c.pass()}});
  }
  Json json = {{"format", "simgap/validate/1"}};
  for (const std::string& unit : errorUnits(result.layout)) {
    json["mje_" + unit] = mjeJson(result.layout, judged.mje, unit);
    json["paper_mje_" + unit] = mjeJson(result.layout, paperAngles(result.layout, judged.mje), unit);
  }
  json.update({{"valid_poses", judged.valid}, {"poses", poses}, {"criteria", criteria}});
  return json;
}

std::string errorsCsv(const ValidationResult& result) {
  std::vector<std::string> header{"pose", "status"};
  for (const JointChannel& joint : result.layout.joints)
    header.push_back(fmt::format("{}_error_{}", joint.name, kindOf(joint.type).error_unit));
  header.push_back("slack_muscles");
  CsvWriter csv(header);
  for (std::size_t p = 0; p < result.set.poses.size(); ++p) {
    csv.add(result.set.poses[p].name).add(toString(result.assessment.outcomes[p].status));
    for (std::size_t j = 0; j < result.layout.joints.size(); ++j) {
      const auto& errors = result.assessment.errors[p];
      errors.empty() ? csv.add("") : csv.add(kindOf(result.layout.joints[j].type).shown(errors[j]));
    }
    csv.add(slackText(result.assessment.outcomes[p], result.layout)).endRow();
  }
  return csv.text();
}

std::string terminalTable(const ValidationResult& result) {
  constexpr std::size_t kMostPoses = 10;
  const Json json = toJson(result);
  Table poses = PoseErrorTables(CsvTable::parse(errorsCsv(result), "errors.csv"), {""}, "replayed").table(false);
  poses.rows.resize(std::min(poses.rows.size(), kMostPoses));
  std::string text = alignedTable(validationErrors(json)) + "\n";
  if (!result.criteria.empty()) text += alignedTable(criteriaTable(json)) + "\n";
  text += "worst poses\n" + alignedTable(poses);
  for (const std::string& line : invalidPoses(result.assessment, result.set, result.layout)) text += line + "\n";
  return text;
}

}  // namespace simgap
