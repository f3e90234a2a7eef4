#include "separation_tables.h"

#include <fmt/format.h>

namespace simgap {
namespace {

Table rivalsTable(const Json& result) {
  Table table{
      "Promised log odds",
      {"model", "role", "before", "more if " + cellText(result.at("named")) + " is right", "more if this one is"},
      {}};
  for (const Json& r : result.at("rivals")) {
    table.rows.push_back(
        {cellText(r.at("causes")), cellText(r.at("role")), numberText(r.at("log_odds_before"), "{:.1f}"),
         numberText(r.at("promised_if_named"), "{:.1f}"), numberText(r.at("promised_if_this"), "{:.1f}")});
  }
  return table;
}

Table countsTable(const Json& result) {
  Table table{"The smallest, after so many poses, by derivatives alone", {"poses", "these", "random ones"}, {}};
  const Json& chosen = result.at("smallest");
  for (std::size_t k = 0; k < chosen.size(); ++k) {
    table.rows.push_back({std::to_string(k + 1), numberText(chosen[k], "{:.2f}"),
                          numberText(result.at("smallest_random")[k], "{:.2f}")});
  }
  return table;
}

std::string beyondText(const Json& protocol) {
  const Json& beyond = protocol.at("beyond");
  return beyond.is_null() ? "" : "beyond: " + cellText(beyond);
}

Table protocolTable(const Json& result) {
  Table table{"The reference log's motion again, so many times as fast, under so many times the load",
              {"speed", "load", "smallest log odds", "nearest model", ""},
              {}};
  for (const Json& p : result.at("protocols")) {
    table.rows.push_back({numberText(p.at("speed"), "{:g}"), numberText(p.at("load"), "{:g}"),
                          numberText(p.at("smallest_log_odds"), "{:.2f}"), cellText(p.at("nearest")), beyondText(p)});
  }
  return table;
}

Table motionsTable(const Json& result) {
  Table table{"The recorded motions again, so many times as fast",
              {"motion", "speed", "smallest log odds", "nearest model", "record"},
              {}};
  for (const Json& p : result.at("protocols")) {
    table.rows.push_back({cellText(p.at("motion")), numberText(p.at("speed"), "{:g}"),
                          numberText(p.at("smallest_log_odds"), "{:.2f}"), cellText(p.at("nearest")),
                          p.at("record").is_null() ? beyondText(p) : cellText(p.at("record"))});
  }
  return table;
}

}  // namespace

std::string separationAnswer(const Json& result) { return cellText(result.at("sentence")) + "."; }

std::vector<Table> separationTables(const Json& result) {
  if (result.value("of", "") == "motions") return {motionsTable(result)};
  if (result.contains("protocols")) return {protocolTable(result)};
  return {rivalsTable(result), countsTable(result)};
}

}  // namespace simgap
