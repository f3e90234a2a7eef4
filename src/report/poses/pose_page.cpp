#include "pose_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "pose_tables.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

/// "before" -> "_before"; nothing for the only state.
std::string suffix(const std::string& state) { return state.empty() ? "" : "_" + state; }

std::string shownName(const std::string& state) { return state.empty() ? "simulated" : state; }

}  // namespace

PoseErrorTables::PoseErrorTables(const CsvTable& table, std::vector<std::string> states, std::string set)
    : states_(std::move(states)) {
  std::vector<std::pair<std::string, std::string>> columns;  // joint and unit
  const std::string ending = "_error" + suffix(states_.back());
  for (const std::string& column : table.columns()) {
    for (const JointKind* kind : joint_kinds::all()) {
      const std::string unit = fmt::format("_{}", kind->error_unit);
      if (!column.ends_with(ending + unit)) continue;
      const std::string joint = column.substr(0, column.size() - ending.size() - unit.size());
      joints_.push_back(jointLabel({joint, kind->type}));
      columns.push_back({joint, unit});
      break;  // kinds with the same unit look the same from here
    }
  }
  const std::vector<std::string> poses = table.text("pose");
  const std::vector<std::string> slack = table.text("slack_muscles" + suffix(states_.back()));
  const std::vector<std::string> sets = set.empty() ? table.text("set") : std::vector(poses.size(), set);
  for (std::size_t i = 0; i < poses.size(); ++i) rows_.push_back({sets[i], poses[i], {}, {}, slack[i]});
  for (const std::string& state : states_) {
    const std::vector<std::string> status = table.text("status" + suffix(state));
    for (std::size_t i = 0; i < rows_.size(); ++i) {
      rows_[i].status.push_back(status[i]);
      rows_[i].errors.emplace_back();
    }
    for (const auto& [joint, unit] : columns) {
      const std::vector<double> errors = numbersOf(table, joint + "_error" + suffix(state) + unit);
      for (std::size_t i = 0; i < rows_.size(); ++i) rows_[i].errors.back().push_back(errors[i]);
    }
  }
}

std::vector<std::string> PoseErrorTables::sets() const {
  std::vector<std::string> names;
  for (const Row& row : rows_) {
    if (std::ranges::find(names, row.set) == names.end()) names.push_back(row.set);
  }
  return names;
}

Chart PoseErrorTables::chart(const std::string& set) const {
  std::vector<Row> rows = worstFirst();
  std::erase_if(rows, [&](const Row& row) { return row.set != set; });
  std::vector<std::string> labels;
  for (const Row& row : rows) labels.push_back(row.pose);
  std::vector<Series> series;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    for (std::size_t s = 0; s < states_.size(); ++s) {
      Series bars{joints_[j] + (states_[s].empty() ? "" : " " + states_[s]), {}, {}};
      bars.colour = static_cast<int>(j);
      bars.faint = s + 1 < states_.size();
      for (const Row& row : rows) bars.y.push_back(row.errors[s][j]);
      series.push_back(bars);
    }
  }
  Chart chart = barChart(fmt::format("Error of each {} pose, worst first", set), labels, {"joint error [deg]"}, series);
  chart.wide = labels.size() > 24;
  chart.spec["poses"] = set;  // a click on a bar shows that pose
  return chart;
}

std::vector<PoseErrorTables::Row> PoseErrorTables::worstFirst() const {
  const auto worst = [](const Row& row) {
    double largest = 0.0;
    for (const double error : row.errors.back()) {
      largest = std::isfinite(error) ? std::max(largest, error) : std::numeric_limits<double>::infinity();
    }
    return largest;
  };
  std::vector<std::string> order = sets();
  std::ranges::reverse(order);
  std::vector<Row> sorted;
  for (const std::string& set : order) {
    const auto begin = static_cast<std::ptrdiff_t>(sorted.size());
    std::ranges::copy_if(rows_, std::back_inserter(sorted), [&](const Row& row) { return row.set == set; });
    std::stable_sort(sorted.begin() + begin, sorted.end(),
                     [&](const Row& a, const Row& b) { return worst(a) > worst(b); });
  }
  return sorted;
}

std::string PoseErrorTables::said(const Row& row, std::size_t state) const {
  std::string text;
  for (std::size_t j = 0; j < joints_.size(); ++j) {
    const bool slides = joints_[j].ends_with(" [mm]");
    const std::string name = slides ? joints_[j].substr(0, joints_[j].size() - 5) : joints_[j];
    text += fmt::format("{}{} {}{}", j ? ", " : "", name, degreesCell(row.errors[state][j]), slides ? " mm" : "°");
  }
  text += " off " + shownName(states_[state]);
  if (!row.slack.empty() && state + 1 == states_.size()) text += "; slack: " + row.slack;
  return text;
}

std::vector<ScenePose> PoseErrorTables::scenePoses() const {
  std::vector<ScenePose> poses;
  for (const Row& row : worstFirst()) {
    ScenePose pose{row.set, row.pose, {}};
    for (std::size_t s = 0; s < states_.size(); ++s) pose.states.emplace_back(shownName(states_[s]), said(row, s));
    poses.push_back(pose);
  }
  return poses;
}

Table PoseErrorTables::table(bool folded) const {
  Table table{"All poses, worst first [deg]", {"pose"}, {}, folded};
  for (const std::string& joint : joints_) {
    for (const std::string& state : states_) table.header.push_back(joint + (state.empty() ? "" : " " + state));
  }
  table.header.insert(table.header.end(), {"status", "slack muscles"});
  for (const Row& row : worstFirst()) {
    std::vector<std::string> line{sets().size() > 1 ? row.set + " " + row.pose : row.pose};
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      for (std::size_t s = 0; s < states_.size(); ++s) line.push_back(degreesCell(row.errors[s][j]));
    }
    line.insert(line.end(), {row.status.back(), row.slack});
    table.rows.push_back(line);
  }
  return table;
}

}  // namespace simgap
