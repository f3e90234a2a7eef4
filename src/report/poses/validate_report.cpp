#include <fmt/format.h>

#include "pose_tables.h"

namespace simgap {
namespace {

/// Pose indices, largest error in any joint first; invalid poses before all.
std::vector<std::size_t> worstFirst(const Assessment& assessment) {
  std::vector<double> worst;
  for (const auto& errors : assessment.errors) {
    worst.push_back(errors.empty() ? kInfinity : *std::max_element(errors.begin(), errors.end()));
  }
  std::vector<std::size_t> order(worst.size());
  std::iota(order.begin(), order.end(), std::size_t{0});
  std::stable_sort(order.begin(), order.end(), [&](std::size_t a, std::size_t b) { return worst[a] > worst[b]; });
  return order;
}

std::vector<std::vector<std::string>> poseRows(const ValidationResult& result, std::size_t most) {
  std::vector<std::vector<std::string>> rows;
  for (const std::size_t p : worstFirst(result.assessment)) {
    if (rows.size() == most) break;
    std::vector<std::string> row{result.set.poses[p].name};
    for (std::size_t j = 0; j < result.layout.joints.size(); ++j) {
      row.push_back(result.assessment.errors[p].empty() ? "-" : degreesText(result.assessment.errors[p][j]));
    }
    row.push_back(describe(result.assessment.outcomes[p], result.layout));
    rows.push_back(row);
  }
  return rows;
}

std::vector<std::string> poseHeader(const ValidationResult& result) {
  std::vector<std::string> header{"pose"};
  for (const JointChannel& joint : result.layout.joints) header.push_back(joint.name);
  return header;
}

}  // namespace

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
  Table errors = validationErrors(toJson(result));
  for (const Criterion& c : result.criteria) {
    errors.rows.push_back(
        {fmt::format("{}: {:.2f}, limit {:.2f}: {}", c.name, c.value, c.limit, c.pass() ? "pass" : "FAIL")});
  }
  std::vector<std::vector<std::string>> rows{poseHeader(result)};
  for (auto& row : poseRows(result, kMostPoses)) rows.push_back(row);
  return alignedTable(errors) + "\nworst poses\n" + alignedTable(rows);
}

}  // namespace simgap
