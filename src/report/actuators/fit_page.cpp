#include "fit_page.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/units.h"

namespace simgap {
namespace {

/// Intervals relative to the value: parameters of any unit stand on one axis.
void addIntervals(const Json& result, Page& page) {
  constexpr double kWidest = 5.0;  // of a relative interval that shares an axis with the others
  std::vector<IntervalRow> rows;
  std::string left_out;
  for (const Json& p : result.at("parameters")) {
    const double value = numberOf(p.at("value"));
    const double lower = numberOf(p.at("ci95").at(0)) / value, upper = numberOf(p.at("ci95").at(1)) / value;
    if (p.at("fixed").get<bool>() || value == 0.0 || !std::isfinite(lower) || !std::isfinite(upper)) continue;
    // Its interval means little, and would press all others into a line.
    if (p.at("at_bound").get<bool>() || std::max(std::abs(lower - 1.0), std::abs(upper - 1.0)) > kWidest) {
      left_out += (left_out.empty() ? "" : ", ") + p.at("name").get<std::string>();
      continue;
    }
    rows.push_back({p.at("name"), 0.0, 100.0 * (std::min(lower, upper) - 1.0), 100.0 * (std::max(lower, upper) - 1.0)});
  }
  if (rows.empty()) return;
  Chart chart = intervalChart("How well each parameter is known", {"95 % interval about the value [%]"}, rows);
  if (!left_out.empty()) chart.note = "Not drawn, because at a bound or hardly known: " + left_out + ".";
  page.add(std::move(chart));
}

void addCorrelation(const ResultFiles& files, Page& page) {
  if (!files.has("correlation.csv")) return;
  const CsvTable table = files.table("correlation.csv");
  Map map;
  map.x_names = map.y_names = table.text("parameter");
  if (map.x_names.size() < 2) return;
  const std::size_t count = map.x_names.size();
  map.value.assign(count * count, std::nan(""));
  for (std::size_t i = 0; i < count; ++i) {
    map.x.push_back(static_cast<double>(i));
    map.y.push_back(static_cast<double>(i));
    const std::vector<double> column = numbersOf(table, map.x_names[i]);
    for (std::size_t j = 0; j < count; ++j) map.value[i + count * j] = column[j];
  }
  map.diverging = true;
  map.range = 1.0;
  map.written = true;
  page.add(mapChart("Correlation of the parameters", {""}, {""}, map));
}

/// Names of the parameters for which `key` is `value`.
std::string parametersWith(const Json& result, const char* key, bool value) {
  std::string names;
  for (const Json& p : result.at("parameters")) {
    if (p.at("fixed").get<bool>() || p.at(key).get<bool>() != value) continue;
    names += (names.empty() ? "" : ", ") + p.at("name").get<std::string>();
  }
  return names;
}

/// Whether the model may be used, and what tells more about it.
PageVerdict fitVerdict(const ResultFiles& files, const std::string& command) {
  constexpr double kOverfitted = 2.0;  // squared error on rows held out, relative to the rows fitted
  const Json& result = files.result();
  PageVerdict verdict{PageVerdict::Level::kGood, "good", "Every parameter is determined by these rows.",
                      fmt::format("simgap diagnose {} --log {}", files.path("model.yaml"), files.input("log", "LOG"))};
  const auto doubt = [&](const char* words, const std::string& cause) {
    verdict.level = PageVerdict::Level::kDoubtful;
    verdict.words = words;
    verdict.cause = cause;
  };
  const std::string unknown = parametersWith(result, "identifiable", false);
  const std::string bound = parametersWith(result, "at_bound", true);
  if (!unknown.empty()) doubt("not determined", "These rows do not tell " + unknown + ".");
  if (!bound.empty()) {
    doubt("at a bound", "The search wanted to go beyond the bounds of " + bound +
                            ": a wrong sign or unit in the log, or a model that does not fit.");
  }
  if (numberOf(result.at("mse_heldout")) > kOverfitted * numberOf(result.at("mse"))) {
    doubt("does not carry over", "The error on rows it was not fitted to is much larger.");
  }
  if (command == "fit-gearbox") verdict.command.clear();  // diagnose takes no gearbox without its motor
  return verdict;
}

}  // namespace

Page beginFitPage(const ResultFiles& files) {
  const Json& result = files.result();
  const std::string format = result.at("format"), command = format.substr(7, format.rfind('/') - 7);
  Page page{"simgap " + command, fitAnswer(result), result.at("warnings").get<std::vector<std::string>>()};
  page.verdict = fitVerdict(files, command);
  return page;
}

void addFitDetails(const ResultFiles& files, Page& page) {
  const Json& result = files.result();
  page.addSection("Parameters");
  if (result.at("comparison").size() > 1) page.add(fitComparison(result));
  page.add(fitParameters(result));
  addIntervals(result, page);
  addCorrelation(files, page);
  page.add(fitFacts(result));
}

void addTimeChart(const ResultFiles& files, Page& page, const std::vector<double>& time,
                  const std::vector<double>& measured,
                  const std::vector<std::pair<std::string, std::vector<double>>>& predicted) {
  std::vector<Series> lines{{"measured", time, measured, Series::Style::kLine, 6, /*faint=*/true}};
  int colour = 0;
  for (const auto& [model, values] : predicted) lines.push_back({model, time, values, Series::Style::kLine, colour++});
  Chart chart = lineChart("Measured and predicted over time", {"time [s]"},
                          {axisTitle(files.result().at("target").get<std::string>())}, lines);
  chart.note = "A stretch from the middle of the log.";
  chart.wide = true;
  makeZoomable(chart);
  page.add(std::move(chart));
  page.add(
      residualChart(time, measured, {predicted.front()}, axisTitle(files.result().at("target").get<std::string>())));
}

Chart residualChart(const std::vector<double>& time, const std::vector<double>& measured,
                    const std::vector<std::pair<std::string, std::vector<double>>>& predicted, const std::string& title,
                    std::size_t most) {
  std::vector<Series> lines;
  for (const auto& [model, values] : predicted) {
    Series line{model, time, values, Series::Style::kLine, static_cast<int>(lines.size())};
    for (std::size_t i = 0; i < line.y.size(); ++i) line.y[i] -= measured[i];
    lines.push_back(thinned(line, most));
  }
  Chart chart = lineChart("Predicted - measured", {"time [s]"}, {title}, lines);
  chart.wide = true;
  makeZoomable(chart);
  return chart;
}

bool isRefit(const ResultFiles& files) { return files.has("predictions.csv"); }

Page refitPage(const ResultFiles& files) {
  constexpr std::size_t kShown = 1500;
  Page page = beginFitPage(files);
  const CsvTable table = files.table("predictions.csv");
  const std::size_t rows = table.rows(), shown = std::min(kShown, rows), begin = (rows - shown) / 2;
  const auto stretch = [&](const char* column) {
    const std::vector<double> all = numbersOf(table, column);
    const auto first = all.begin() + static_cast<std::ptrdiff_t>(begin);
    return std::vector<double>(first, first + static_cast<std::ptrdiff_t>(shown));
  };
  const std::vector<double> time = stretch("time_s");
  addTimeChart(files, page, time, stretch("measured"), {{files.result().at("model"), stretch("predicted")}});
  addFitDetails(files, page);
  return page;
}

std::string columnLike(const CsvTable& table, std::string_view stem) {
  for (const std::string& column : table.columns()) {
    if (column == stem || splitUnit(column).stem == stem) return column;
  }
  throw DataError(fmt::format("{}: found no column {}, expected one (with a unit or without)", table.name(), stem));
}

std::vector<Series> seriesOf(const CsvTable& table, const std::string& x, const std::string& y,
                             const std::function<bool(std::size_t)>& shown) {
  const std::vector<std::string> names = table.text("series");
  const std::vector<double> xs = numbersOf(table, x), ys = numbersOf(table, y);
  std::vector<Series> lines;
  int models = 0;
  for (std::size_t i = 0; i < names.size(); ++i) {
    if (shown && !shown(i)) continue;
    auto line = std::ranges::find(lines, names[i], &Series::name);
    if (line == lines.end()) {
      const bool measured = names[i] == "measured";
      lines.push_back({names[i], {}, {}, measured ? Series::Style::kPoints : Series::Style::kLine});
      line = lines.end() - 1;
      line->colour = measured ? 6 : models++;
    }
    line->x.push_back(xs[i]);
    line->y.push_back(ys[i]);
  }
  return lines;
}

Map gridOf(const CsvTable& table, const std::string& x, const std::string& y, const std::vector<double>& value) {
  const std::vector<double> xs = numbersOf(table, x), ys = numbersOf(table, y);
  const auto distinct = [](std::vector<double> values) {
    std::erase_if(values, [](double at) { return !std::isfinite(at); });  // they cannot be sorted
    std::ranges::sort(values);
    values.erase(std::unique(values.begin(), values.end()), values.end());
    return values;
  };
  constexpr std::size_t kMostCells = 1'000'000;
  const auto known = [](double at) { return std::isfinite(at); };
  Map map;
  map.x = distinct(xs);
  map.y = distinct(ys);
  if (!std::ranges::all_of(xs, known) || !std::ranges::all_of(ys, known) || map.x.size() * map.y.size() > kMostCells) {
    throw DataError(fmt::format("{}: {} and {} make no grid: found {} x {} places, expected known ones, {} at most",
                                table.name(), x, y, map.x.size(), map.y.size(), kMostCells));
  }
  map.value.assign(map.x.size() * map.y.size(), std::nan(""));
  for (std::size_t i = 0; i < value.size(); ++i) {
    const auto column = std::ranges::lower_bound(map.x, xs[i]) - map.x.begin();
    const auto row = std::ranges::lower_bound(map.y, ys[i]) - map.y.begin();
    map.value[static_cast<std::size_t>(column) + map.x.size() * static_cast<std::size_t>(row)] = value[i];
  }
  return map;
}

}  // namespace simgap
