#include <fmt/format.h>

#include "motion_says.h"
#include "simgap/report/diagnosis/diagnosis_report.h"

namespace simgap {

Json toJson(const MotionDiagnosis& result) {
  Json json = toJson(result.diagnosis), motions = Json::array();
  for (const MotionSay& say : result.motions) {
    motions.push_back({{"name", say.motion},
                       {"set", say.held_out ? "held out" : "selection"},
                       {"mse_before", numberOrNull(say.before)},
                       {"mse_after", numberOrNull(say.after)},
                       {"evidence", numberOrNull(say.evidence)},
                       {"worst", say.worst}});
  }
  json["motions"] = motions;
  json["rollouts"] = result.rollouts;
  return json;
}

std::string terminalTable(const MotionDiagnosis& result) {
  std::string text = terminalTable(result.diagnosis);
  if (!result.motions.empty()) text += alignedTable(motionSays(toJson(result))) + "\n";
  return text;
}

Table motionSays(const Json& result) {
  Table table{
      "What each motion says", {"motion", "set", "RMS before", "after", "evidence", "worst with the causes"}, {}};
  const auto root = [](const Json& square) {
    return square.is_number() ? fmt::format("{:.2f}", std::sqrt(square.get<double>())) : std::string("-");
  };
  for (const Json& say : result.at("motions")) {
    table.rows.push_back({say.at("name"), say.at("set"), root(say.at("mse_before")), root(say.at("mse_after")),
                          say.at("evidence").is_number() ? fmt::format("{:.1f}", say.at("evidence").get<double>()) : "",
                          say.at("worst")});
  }
  return table;
}

}  // namespace simgap
