#include <fmt/format.h>
#include <fmt/ranges.h>

#include "robot_says.h"
#include "simgap/core/csv.h"
#include "simgap/report/diagnosis/diagnosis_report.h"

namespace simgap {

using Eigen::Index;

Json toJson(const RobotDiagnosis& result) {
  Json json = toJson(result.diagnosis), joints = Json::array();
  for (const JointVerdict& joint : result.joints) {
    joints.push_back({{"name", joint.joint},
                      {"effort_unit", joint.unit},
                      {"error_given", numberOrNull(joint.given)},
                      {"error_before", numberOrNull(joint.before)},
                      {"error_after", numberOrNull(joint.after)},
                      {"times_known", numberOrNull(joint.times_known)}});
  }
  Json elsewhere = Json::array();
  for (const LeftAtJoint& left : result.elsewhere) {
    for (const Leftover& channel : left.channels) {
      elsewhere.push_back(
          {{"joint", left.joint}, {"channel", channel.channel}, {"share_percent", 100.0 * channel.share}});
    }
  }
  json["left_elsewhere"] = elsewhere;
  json["joints"] = joints;
  json["not_held"] = result.not_held;
  return json;
}

Table robotSays(const Json& result) {
  Table table{"Errors of the joints on data never used, of their effort", {"joint", "as given", "before", "after"}, {}};
  const auto percent = [](const Json& error) {
    return error.is_number() ? fmt::format("{:.2f} %", 100.0 * error.get<double>()) : std::string("-");
  };
  for (const Json& joint : result.at("joints")) {
    table.rows.push_back({joint.at("name"), percent(joint.at("error_given")), percent(joint.at("error_before")),
                          percent(joint.at("error_after"))});
  }
  return table;
}

std::string terminalTable(const RobotDiagnosis& result) {
  std::string text = terminalTable(result.diagnosis);
  if (result.joints.empty()) return text;
  text += alignedTable(robotSays(toJson(result))) + "\n";
  if (!result.not_held.empty()) {
    text += fmt::format("{} {}: a robot's file cannot hold it\n",
                        result.extended ? "model.yaml is without" : "no model.yaml is written for",
                        fmt::join(result.not_held, ", "));
  }
  return text;
}

std::string robotPredictionsCsv(const RobotDiagnosis& result, const RobotLog& log) {
  std::vector<std::string> header = {"time_s"};
  for (const RobotJointLog& joint : log.joints) {
    for (const char* what : {"measured", "before", "after"}) {
      header.push_back(fmt::format("{}_{}_{}", joint.name, what, joint.effort_unit));
    }
  }
  CsvWriter csv(header);
  for (std::size_t i = 0; i < log.rows(); ++i) {
    csv.add(log.time[i]);
    for (std::size_t c = 0; c < log.joints.size(); ++c) {
      const auto row = static_cast<Index>(i), column = static_cast<Index>(c);
      csv.add(log.joints[c].effort[i]).add(result.before(row, column)).add(result.after(row, column));
    }
    csv.endRow();
  }
  return csv.text();
}

}  // namespace simgap
