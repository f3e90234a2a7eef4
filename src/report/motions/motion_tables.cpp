#include "motion_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <map>

#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

/// "shoulder_deg" is "shoulder [deg]".
std::string titleOf(const std::string& key) {
  const auto cut = key.rfind('_');
  return fmt::format("{} [{}]", key.substr(0, cut), key.substr(cut + 1));
}

}  // namespace

Json rmsJson(const MotionRms& rms, const PoseLayout& layout) {
  Json json = Json::object();
  for (std::size_t j = 0; j < layout.joints.size(); ++j) {
    const JointKind& kind = kindOf(layout.joints[j].type);
    json[fmt::format("{}_{}", layout.joints[j].name, kind.error_unit)] = numberOrNull(kind.shown(rms.joints[j]));
  }
  json["shafts_deg"] = numberOrNull(toDegrees(rms.shafts));
  json["currents_A"] = numberOrNull(rms.currents);
  return json;
}

Table rmsTable(const std::string& caption, const std::vector<std::pair<std::string, Json>>& rows) {
  Table table{caption, {""}, {}};
  for (const auto& [key, value] : rows.front().second.items()) table.header.push_back(titleOf(key));
  for (const auto& [name, values] : rows) {
    std::vector<std::string> row{name};
    for (const auto& [key, value] : values.items()) row.push_back(numberText(value, "{:.3f}"));
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table calibrationRms(const Json& result) {
  std::vector<std::pair<std::string, Json>> rows;
  for (const auto& [set, rms] : result.at("motion_rms").items()) {
    rows.emplace_back(set + " before", rms.at("initial"));
    rows.emplace_back(set + " after", rms.at("final"));
  }
  if (result.contains("predicted_motion_rms")) {
    for (const auto& [set, predicted] : result.at("predicted_motion_rms").items()) {
      rows.emplace_back(set + " predicted", predicted.at("mean"));
      rows.emplace_back("  from (5 %)", predicted.at("lower"));
      rows.emplace_back("  to (95 %)", predicted.at("upper"));
    }
  }
  rows.emplace_back("noise", result.at("noise"));
  return rmsTable("Root mean square errors of motions; a ball's per axis", rows);
}

Table validationRms(const Json& result) {
  std::vector<std::pair<std::string, Json>> rows;
  for (const Json& motion : result.at("motions")) rows.emplace_back(motion.at("name"), motion.at("rms"));
  rows.emplace_back("all", result.at("motion_rms"));
  rows.emplace_back("noise", result.at("noise"));
  return rmsTable("Root mean square errors; a ball's per axis", rows);
}

Table worstChannels(const Json& result) {
  constexpr std::size_t kMost = 10;
  std::vector<const Json*> channels;
  for (const Json& motion : result.at("motions")) {
    for (const Json& channel : motion.at("channels")) channels.push_back(&channel);
  }
  std::ranges::stable_sort(channels, std::greater(),
                           [](const Json* c) { return numberOf(c->at("worst_second")) / numberOf(c->at("noise")); });
  channels.resize(std::min(channels.size(), kMost));
  Table table{"Worst seconds", {"motion, channel", "unit", "rms", "worst second", "at [s]", "noise", "lag [ms]"}, {}};
  for (const Json* c : channels) {
    table.rows.push_back(
        {fmt::format("{}, {}", c->at("motion").get<std::string>(), c->at("channel").get<std::string>()), c->at("unit"),
         numberText(c->at("rms"), "{:.3f}"), numberText(c->at("worst_second"), "{:.3f}"),
         numberText(c->at("worst_at_s"), "{:.2f}"), numberText(c->at("noise"), "{:.3f}"),
         numberText(c->at("lag_ms"), "{:.1f}")});
  }
  return table;
}

void addResidualCharts(const ResultFiles& files, Page& page) {
  const CsvTable table = files.table("residuals.csv");
  const std::vector<std::string> sets = table.text("set"), motions = table.text("motion"), models = table.text("model"),
                                 joints = table.text("joint"), units = table.text("unit");
  const std::vector<double> times = numbersOf(table, "time_s"), errors = numbersOf(table, "error");
  using ChartKey = std::pair<std::string, std::string>;  // caption, unit
  std::vector<std::pair<ChartKey, std::vector<Series>>> charts;
  std::map<ChartKey, std::size_t> chart_of;
  for (std::size_t row = 0; row < times.size(); ++row) {
    const std::string caption = sets[row].empty() ? motions[row] : sets[row] + ", " + motions[row];
    const std::string name = models[row].empty() ? joints[row] : joints[row] + ", " + models[row];
    const ChartKey key{caption, units[row]};
    const auto [place, is_new] = chart_of.try_emplace(key, charts.size());
    if (is_new) charts.emplace_back(key, std::vector<Series>());
    std::vector<Series>& series = charts[place->second].second;
    auto one = std::ranges::find(series, name, &Series::name);
    if (one == series.end()) {
      series.push_back({name, {}, {}});
      series.back().faint = models[row] == "before";
      one = series.end() - 1;
    }
    one->x.push_back(times[row]);
    one->y.push_back(errors[row]);
  }
  for (auto& [key, series] : charts) {
    for (Series& one : series) one = thinned(one, 400);
    Chart chart = lineChart(key.first, {"time [s]"}, {fmt::format("joint error [{}]", key.second)}, series);
    makeZoomable(chart, key.first);
    page.add(std::move(chart));
  }
}

}  // namespace simgap
