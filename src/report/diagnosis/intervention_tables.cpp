#include "intervention_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/intervene/intervention.h"

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

/// Of motions, whose errors count in standard deviations of the noise.
Table judgedMotionsTable(const Json& result) {
  Table table{"What each model predicted, with nothing refitted",
              {"model", "role", "RMS [sd]", "left [sd]", "p", "ln odds", "before"},
              {}};
  for (const Json& c : result.at("candidates")) {
    table.rows.push_back({cellText(c.at("causes")), cellText(c.at("role")), numberText(c.at("rms_sd"), "{:.2f}"),
                          numberText(c.at("left_sd"), "{:.2f}"), probabilityText(c.at("p")),
                          numberText(c.at("log_odds"), "{:.1f}"), numberText(c.at("log_odds_before"), "{:.1f}")});
  }
  return table;
}

/// Of a log, whose effort has a unit.
Table judgedLogTable(const Json& result) {
  const std::string unit = unitTitle(cellText(result.at("unit")));
  Table table{"What each model predicted, with nothing refitted",
              {"model", "role", fmt::format("RMS [{}]", unit), fmt::format("before [{}]", unit), "distance", "of", "p",
               "ln odds", "before"},
              {}};
  for (const Json& c : result.at("candidates")) {
    table.rows.push_back({cellText(c.at("causes")), cellText(c.at("role")), numberText(c.at("rms"), "{:.4g}"),
                          numberText(c.at("rms_before"), "{:.4g}"), numberText(c.at("distance"), "{:.0f}"),
                          numberText(c.at("freedom"), "{:.0f}"), probabilityText(c.at("p")),
                          numberText(c.at("log_odds"), "{:.1f}"), numberText(c.at("log_odds_before"), "{:.1f}")});
  }
  return table;
}

Table foreseenLogTable(const Json& change, const std::string& unit) {
  Table table{cellText(change.at("name")),
              {"model", fmt::format("differs most [{}]", unit), "in noise", "where", "ln odds, named right",
               "ln odds, this right"},
              {}};
  for (const Json& c : change.at("candidates")) {
    if (cellText(c.at("role")) == "named") continue;
    table.rows.push_back({cellText(c.at("causes")), numberText(c.at("largest_shift"), "{:.3g}"),
                          numberText(c.at("in_noise"), "{:.1f}"), cellText(c.at("where")),
                          numberText(c.at("log_odds_if_named"), "{:.1f}"),
                          numberText(c.at("log_odds_if_this"), "{:.1f}")});
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

std::string foreseenSentence(const std::string& named, const std::string& change, double log_odds) {
  if (!std::isfinite(log_odds)) {
    return fmt::format("no model of the diagnosis contradicts {}: there is nothing to tell apart", named);
  }
  return log_odds > kDecisiveLogOdds
             ? fmt::format("{} would tell {} from every other model (expected {} at least)", change, named,
                           saidOdds(log_odds))
             : fmt::format(
                   "none of these changes is expected to tell {} from every other model ({:.2g} to 1 at best, {})",
                   named, oddsOf(log_odds), change);
}

std::string interventionAnswer(const Json& result) {
  const std::string verdict = cellText(result.at("verdict"));
  if (verdict == "foreseen") return fmt::format("foreseen: {}.", cellText(result.at("sentence")));
  const std::string data = result.contains("rows") ? "rows" : result.contains("motions") ? "motions" : "poses";
  return fmt::format("{}: {}. {} of {} {} compared.", verdict, cellText(result.at("sentence")),
                     cellText(result.at(data)), cellText(result.at(data + "_given")), data);
}

std::vector<Table> interventionTables(const Json& result) {
  std::vector<Table> tables;
  const bool of_log = result.contains("unit");
  if (result.contains("candidates")) {
    tables.push_back(of_log                       ? judgedLogTable(result)
                     : result.contains("motions") ? judgedMotionsTable(result)
                                                  : judgedTable(result));
    return tables;
  }
  for (const Json& change : result.at("changes")) {
    tables.push_back(of_log ? foreseenLogTable(change, unitTitle(cellText(result.at("unit")))) : foreseenTable(change));
  }
  return tables;
}

}  // namespace simgap
