#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/diagnosis/intervention_tables.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::intervene {
namespace {

/// The error of every model in every pose and joint, or motion and channel, after the change.
Chart errorsChart(const ResultFiles& files, const Json& result) {
  const CsvTable table = files.table("predictions.csv");
  const bool of_motions = result.contains("motions");
  const std::vector<std::string> pose = table.text(of_motions ? "motion" : "pose"),
                                 joint = table.text(of_motions ? "channel" : "joint");
  std::vector<std::string> names;
  for (std::size_t i = 0; i < pose.size(); ++i) names.push_back(pose[i] + " " + joint[i]);
  std::vector<Series> series;
  std::size_t number = 0;
  for (const Json& c : result.at("candidates")) {
    if (number < 3) {
      const std::string label = cellText(c.at("causes"));
      series.push_back({label, {}, numbersOf(table, fmt::format("{:02} {}", number, label))});
    }
    ++number;
  }
  return barChart("Errors after the change, with nothing refitted", names,
                  {of_motions ? "RMS error [sd of the noise]" : "error [deg], of a slide [mm]"}, series);
}

/// Over time: what was measured, if it was, and what the first three models say.
void addPredictions(const ResultFiles& files, const Json& result, const Json& candidates, Page& page) {
  const CsvTable table = files.table("predictions.csv");
  const std::vector<double> time = numbersOf(table, "time_s");
  const Axis effort{fmt::format("[{}]", unitTitle(cellText(result.at("unit"))))};
  std::vector<Series> series, left;
  std::vector<double> measured;
  if (table.has("measured")) {
    measured = numbersOf(table, "measured");
    series.push_back({"measured", time, measured, Series::Style::kLine, 6, /*faint=*/true});
  }
  for (std::size_t c = 0; c < std::min<std::size_t>(candidates.size(), 3); ++c) {
    const std::string label = cellText(candidates[c].at("causes"));
    std::vector<double> values = numbersOf(table, fmt::format("{:02} {}", c, label));
    series.push_back({label, time, values, Series::Style::kLine, static_cast<int>(c)});
    for (std::size_t i = 0; i < measured.size(); ++i) values[i] = measured[i] - values[i];
    if (!measured.empty()) left.push_back({label, time, std::move(values), Series::Style::kLine, static_cast<int>(c)});
  }
  const auto add = [&](const char* caption, const std::vector<Series>& lines) {
    if (lines.empty()) return;
    Chart chart = lineChart(caption, {"time [s]"}, effort, lines);
    chart.wide = true;
    makeZoomable(chart);
    page.add(std::move(chart));
  };
  add("Predicted after the change, with nothing refitted", series);
  add("What is left: measured - predicted", left);
}

Chart oddsChart(const Json& candidates, const char* key, const std::string& title) {
  std::vector<std::string> names;
  std::vector<double> odds;
  for (const Json& c : candidates) {
    names.push_back(cellText(c.at("causes")));
    odds.push_back(numberOf(c.at(key)));
  }
  return barChart(title, names, {"log of the odds"}, {{"log odds", {}, odds}});
}

PageVerdict verdictOf(const Json& result) {
  const std::string verdict = cellText(result.at("verdict"));
  using Level = PageVerdict::Level;
  const Level level = verdict == "confirmed" ? Level::kGood : Level::kDoubtful;
  const std::string next =
      verdict == "cannot-tell" || verdict == "foreseen"
          ? "A change that moves the models' predictions further apart tells more."
          : "What the change says holds for the models listed; another cause may predict the same.";
  return {level, verdict, next,
          result.contains("unit")                    ? "simgap intervene RUN --change CHANGE --log AFTER"
          : result.value("of", "poses") == "motions" ? "simgap intervene RUN --change CHANGE --motions AFTER"
                                                     : "simgap intervene RUN --change CHANGE --poses AFTER"};
}

const Json& bestChange(const Json& result) {
  const Json& changes = result.at("changes");
  const auto best =
      std::ranges::find_if(changes, [&](const Json& change) { return change.at("name") == result.at("best"); });
  return best != changes.end() ? *best : changes.at(0);
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"simgap intervene", interventionAnswer(result), {}};
  page.verdict = verdictOf(result);
  const bool of_log = result.contains("unit");
  if (of_log) {
    const Json& shown = result.contains("candidates") ? result.at("candidates") : bestChange(result).at("candidates");
    addPredictions(files, result, shown, page);
  }
  if (result.contains("candidates")) {
    if (!of_log) page.add(errorsChart(files, result));
    page.add(oddsChart(result.at("candidates"), "log_odds", "What came after the change says, against the first"));
    for (const Json& pose : result.value("left_out", Json::array())) {
      page.notes.push_back(fmt::format("No model comes near pose {}: it was left out.", cellText(pose)));
    }
  } else {
    for (const Json& change : result.at("changes")) {
      page.add(oddsChart(change.at("candidates"), "log_odds_if_named",
                         cellText(change.at("name")) + ": expected odds of the named model over each"));
    }
  }
  for (Table& table : interventionTables(result)) page.add(std::move(table));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/intervene/1", make};

}  // namespace simgap::pages::intervene
