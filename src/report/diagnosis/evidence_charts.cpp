#include "report/diagnosis/evidence_charts.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

namespace simgap {
namespace {

/// Channels, first those against which the causes took away most of the squared mean residual.
std::vector<std::string> channelsByGain(const CsvTable& table) {
  const std::vector<std::string> against = table.text("against");
  const std::vector<double> before = numbersOf(table, "before"), after = numbersOf(table, "after");
  const std::vector<double> rows = numbersOf(table, "rows");
  std::map<std::string, double> gain;
  for (std::size_t i = 0; i < against.size(); ++i) {
    const double taken = rows[i] * (before[i] * before[i] - after[i] * after[i]);
    if (std::isfinite(taken)) gain[against[i]] += taken;
  }
  std::vector<std::string> channels = distinctOf(table, "against");
  std::ranges::stable_sort(channels, std::greater(), [&](const std::string& channel) { return gain[channel]; });
  return channels;
}

/// Of the channel, where its name does not say it; runs of earlier versions have none.
std::string channelUnit(const CsvTable& table, const std::string& against) {
  if (std::ranges::find(table.columns(), "unit") == table.columns().end()) return {};
  const std::vector<std::string> all = table.text("against");
  return table.text("unit")[std::ranges::find(all, against) - all.begin()];
}

}  // namespace

Chart evidenceChart(const CsvTable& table, const std::string& against, const std::string& unit) {
  const auto column = [&](const char* name) { return numbersWhere(table, name, "against", against); };
  Series before{"before", column("center"), column("before"), Series::Style::kLine, 1};
  Series after{"with the causes", column("center"), column("after"), Series::Style::kLine, 0};
  before.half = column("before_ci95");
  after.half = column("after_ci95");
  constexpr std::string_view kAgainst = " against ";  // "error of elbow [deg] against time_s" names the quantity, too
  const std::size_t split = against.find(kAgainst);
  const bool named = split != std::string::npos;
  const std::string channel = named ? against.substr(split + kAgainst.size()) : against;
  const std::string quantity = named ? "mean " + against.substr(0, split) : fmt::format("mean residual [{}]", unit);
  const std::string title = (named ? against.substr(0, against.find(" [")) + " against " : "Against ") + channel;
  const std::string own = channelUnit(table, against);
  return lineChart(capitalised(title), {own.empty() ? channel : fmt::format("{} [{}]", channel, unitTitle(own))},
                   {quantity}, {before, after});
}

EvidenceTable evidenceOf(const ResultFiles& files) {
  if (!files.has("evidence.csv")) return {CsvTable::parse("against\n", "evidence.csv"), {}};
  CsvTable table = files.table("evidence.csv");
  std::vector<std::string> channels = channelsByGain(table);
  return {std::move(table), std::move(channels)};
}

}  // namespace simgap
