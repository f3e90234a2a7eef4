#include <algorithm>

#include "pose_page.h"
#include "pose_tables.h"

namespace simgap {

Json toJson(const ValidationResult& result) {
  const Assessment& judged = result.assessment;
  Json poses = Json::array();
  for (std::size_t p = 0; p < result.set.poses.size(); ++p) {
    const bool steady = !judged.errors[p].empty();
    poses.push_back({{"pose", result.set.poses[p].name},
                     {"status", toString(judged.outcomes[p].status)},
                     {"error_deg", steady ? mjeJson(result.layout, judged.errors[p]) : Json(nullptr)},
                     {"slack", slackMuscles(judged.outcomes[p], result.layout)}});
  }
  Json criteria = Json::array();
  for (const Criterion& c : result.criteria) {
    criteria.push_back({{"name", c.name}, {"limit", c.limit}, {"value", numberOrNull(c.value)}, {"pass", c.pass()}});
  }
  return {{"format", "simgap/validate/1"},
          {"mje_deg", mjeJson(result.layout, judged.mje)},
          {"paper_mje_deg", mjeJson(result.layout, paperAngles(result.layout, judged.mje))},
          {"valid_poses", judged.valid},
          {"poses", poses},
          {"criteria", criteria}};
}

std::string errorsCsv(const ValidationResult& result) {
  std::vector<std::string> header{"pose", "status"};
  for (const JointChannel& joint : result.layout.joints) header.push_back(joint.name + "_error_deg");
  header.push_back("slack_muscles");
  CsvWriter csv(header);
  for (std::size_t p = 0; p < result.set.poses.size(); ++p) {
    csv.add(result.set.poses[p].name).add(toString(result.assessment.outcomes[p].status));
    for (std::size_t j = 0; j < result.layout.joints.size(); ++j) {
      const auto& errors = result.assessment.errors[p];
      errors.empty() ? csv.add("") : csv.add(toDegrees(errors[j]));
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
