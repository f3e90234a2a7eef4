#include "intervention_tables.h"

#include <fmt/format.h>

namespace simgap {
namespace {

Table judgedTable(const Json& result) {
  Table table{"What each model predicted, with nothing refitted",
              {"model", "role", "RMS [deg]", "distance", "of", "p", "ln odds", "before"},
              {}};
  for (const Json& c : result.at("candidates")) {
    table.rows.push_back({cellText(c.at("causes")), cellText(c.at("role")), numberText(c.at("rms_deg"), "{:.3f}"),
                          numberText(c.at("distance"), "{:.1f}"), cellText(c.at("freedom")), probabilityText(c.at("p")),
                          numberText(c.at("log_odds"), "{:.1f}"), numberText(c.at("log_odds_before"), "{:.1f}")});
  }
  return table;
}

Table foreseenTable(const Json& change) {
  Table table{cellText(change.at("name")),
              {"model", "differs most [deg]", "where", "ln odds, named right", "ln odds, this right"},
              {}};
  for (const Json& c : change.at("candidates")) {
    if (cellText(c.at("role")) == "named") continue;
    table.rows.push_back({cellText(c.at("causes")), numberText(c.at("largest_shift_deg"), "{:.2f}"),
                          cellText(c.at("where")), numberText(c.at("log_odds_if_named"), "{:.1f}"),
                          numberText(c.at("log_odds_if_this"), "{:.1f}")});
  }
  return table;
}

}  // namespace

std::string interventionAnswer(const Json& result) {
  const std::string verdict = cellText(result.at("verdict"));
  if (verdict == "foreseen") return fmt::format("foreseen: {}.", cellText(result.at("sentence")));
  return fmt::format("{}: {}. {} of {} poses compared.", verdict, cellText(result.at("sentence")),
                     cellText(result.at("poses")), cellText(result.at("poses_given")));
}

std::vector<Table> interventionTables(const Json& result) {
  std::vector<Table> tables;
  if (result.contains("candidates")) {
    tables.push_back(judgedTable(result));
  } else {
    for (const Json& change : result.at("changes")) tables.push_back(foreseenTable(change));
  }
  return tables;
}

}  // namespace simgap
