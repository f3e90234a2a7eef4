// The pictures of 003 (figures 10, 12-14 and 16) on the user's data.
#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <utility>

#include "report/actuators/fit_page.h"
#include "simgap/core/error.h"
#include "simgap/core/units.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::fit_friction {
namespace {

constexpr const char* kErrorColumn = "mean_abs_error_";

std::vector<std::string> lawsOf(const Json& result) {
  std::vector<std::string> laws;
  for (const Json& row : result.at("comparison")) laws.push_back(row.at("model"));
  if (laws.empty()) throw DataError("result.json: comparison: found no model, expected at least one");
  return laws;
}

void addTime(const ResultFiles& files, Page& page) {
  const CsvTable series = files.table("series.csv");
  std::vector<std::pair<std::string, std::vector<double>>> predicted;
  std::vector<std::string> laws = lawsOf(files.result());  // the chosen one is drawn on top
  const auto chosen = std::ranges::find(laws, files.result().at("model").get<std::string>());
  if (chosen != laws.end()) std::rotate(laws.begin(), chosen, chosen + 1);
  for (const std::string& law : laws) predicted.emplace_back(law, numbersOf(series, law));
  addTimeChart(files, page, numbersOf(series, "time_s"), numbersOf(series, "measured"), predicted);
}

/// Friction over velocity, one chart per band of load.
void addBands(const ResultFiles& files, Page& page) {
  if (!files.has("curves.csv")) return;
  const CsvTable table = files.table("curves.csv");
  const std::string velocity = columnLike(table, "velocity"), friction = columnLike(table, "friction");
  const std::vector<std::string> band = table.text("band");
  page.addSection("Friction curves per band of load");
  for (const std::string& one : distinctOf(table, "band")) {
    const std::vector<Series> lines =
        seriesOf(table, velocity, friction, [&](std::size_t row) { return band[row] == one; });
    page.add(lineChart("Load " + one, {axisTitle(velocity)}, {axisTitle(friction)}, lines));
  }
}

void addFriction(const ResultFiles& files, Page& page) {
  const CsvTable table = files.table("friction.csv");
  const std::string velocity = columnLike(table, "velocity"), friction = columnLike(table, "friction");
  const std::string load = columnLike(table, "load");
  std::vector<Series> lines;
  for (const std::string& value : distinctOf(table, load)) {
    lines.push_back({fmt::format("at {:.3g}", parseNumber(value).value_or(std::nan(""))),
                     numbersWhere(table, velocity, load, value), numbersWhere(table, friction, load, value)});
  }
  page.add(lineChart(
      fmt::format("Friction of {} at values of {}", files.result().at("model").get<std::string>(), axisTitle(load)),
      {axisTitle(velocity)}, {axisTitle(friction)}, lines));
}

/// The rectangles that the data should reach.
std::vector<Series> requirements(const ResultFiles& files) {
  std::vector<Series> outlines;
  if (!files.has("requirements.csv")) return outlines;
  const CsvTable table = files.table("requirements.csv");
  const std::vector<std::string> names = table.text("name"), covered = table.text("covered");
  const std::vector<double> velocity = numbersOf(table, columnLike(table, "velocity"));
  const std::vector<double> load = numbersOf(table, columnLike(table, "load"));
  for (std::size_t i = 0; i < names.size(); ++i) {
    const double v = velocity[i], l = load[i];
    outlines.push_back(
        {names[i] + (covered[i] == "true" ? " (covered)" : " (NOT covered)"), {-v, v, v, -v, -v}, {-l, -l, l, l, -l}});
    if (covered[i] != "true") outlines.back().style = Series::Style::kDashed;
  }
  return outlines;
}

void addMaps(const ResultFiles& files, Page& page) {
  const CsvTable table = files.table("maps.csv");
  const std::string velocity = columnLike(table, "velocity"), load = columnLike(table, "load");
  const Axis x{axisTitle(velocity)}, y{axisTitle(load)};
  const std::vector<std::string> laws = lawsOf(files.result());
  const auto grid = [&](const std::vector<double>& value) { return gridOf(table, velocity, load, value); };
  page.addSection("Where the model errs");
  Map coverage = grid(numbersOf(table, "rows"));
  coverage.logarithmic = true;
  coverage.unit = "rows";
  coverage.outlines = requirements(files);
  page.add(mapChart("Where the data are", x, y, coverage));
  const std::string target = axisTitle(files.result().at("target").get<std::string>());
  const std::size_t bracket = target.rfind('[');
  const std::string unit = bracket == std::string::npos ? "" : target.substr(bracket + 1, target.size() - bracket - 2);
  const std::vector<double> first = numbersOf(table, kErrorColumn + laws.front());
  Map error = grid(first);
  error.unit = unit;
  page.add(mapChart("Mean absolute error of " + laws.front(), x, y, error));
  for (std::size_t l = 1; l < laws.size(); ++l) {
    std::vector<double> gain = numbersOf(table, kErrorColumn + laws[l]);
    for (std::size_t i = 0; i < gain.size(); ++i) gain[i] = first[i] - gain[i];
    Map better = grid(gain);
    better.diverging = true;
    better.unit = unit;
    Chart chart = mapChart(fmt::format("Improvement of {} over {}", laws[l], laws.front()), x, y, better);
    chart.note = "Positive (blue): the error has become smaller.";
    page.add(std::move(chart));
  }
}

/// How many rows there are at which velocity, load and angle.
void addHistograms(const ResultFiles& files, Page& page) {
  if (!files.has("histograms.csv")) return;
  const CsvTable table = files.table("histograms.csv");
  page.addSection("How the rows are spread");
  for (const std::string& quantity : distinctOf(table, "quantity")) {
    const std::vector<double> lower = numbersWhere(table, "lower", "quantity", quantity),
                              upper = numbersWhere(table, "upper", "quantity", quantity);
    std::vector<std::string> labels;
    for (std::size_t b = 0; b < lower.size(); ++b) labels.push_back(fmt::format("{:.3g}", 0.5 * (lower[b] + upper[b])));
    const std::string title = axisTitle(quantity);
    page.add(barChart(title, labels, {"rows"}, {{title, {}, numbersWhere(table, "rows", "quantity", quantity)}}));
  }
}

/// Cost over the two non-linear parameters: one valley or several.
void addProfile(const ResultFiles& files, Page& page) {
  const CsvTable table = files.table("profile.csv");
  const std::string model = files.result().at("model");
  const auto column = [&](const char* name) { return numbersWhere(table, name, "model", model); };
  const std::vector<double> v_s = column("v_s"), delta = column("delta"), mse = column("mse");
  if (mse.size() < 4) return;
  const double lowest = std::ranges::min(mse);
  CsvWriter scaled({"log10_v_s", "log10_delta"});
  std::vector<double> above;
  for (std::size_t i = 0; i < mse.size(); ++i) {
    scaled.add(std::log10(v_s[i])).add(std::log10(delta[i])).endRow();
    above.push_back(1e-3 + 100.0 * (mse[i] / lowest - 1.0));
  }
  Map map = gridOf(CsvTable::parse(scaled.text(), "profile.csv"), "log10_v_s", "log10_delta", above);
  map.logarithmic = true;
  map.unit = "% above the lowest";
  page.add(mapChart(fmt::format("Cost of {} over the Stribeck velocity and exponent", model), {"log10 v_s"},
                    {"log10 delta"}, map));
}

/// Parameters of all laws side by side, relative to the largest.
void addModels(const ResultFiles& files, Page& page) {
  const CsvTable table = files.table("models.csv");
  const std::vector<std::string> model = table.text("model"), name = table.text("name");
  const std::vector<double> value = numbersOf(table, "value");
  const std::vector<std::string> laws = lawsOf(files.result()), names = distinctOf(table, "name");
  if (laws.size() < 2) return;
  std::vector<Series> bars;
  for (const std::string& law : laws) bars.push_back({law, {}, std::vector<double>(names.size(), std::nan(""))});
  for (std::size_t n = 0; n < names.size(); ++n) {
    double largest = 0.0;
    for (const double v : numbersWhere(table, "value", "name", names[n])) largest = std::fmax(largest, std::abs(v));
    for (std::size_t i = 0; i < name.size(); ++i) {
      const auto bar = std::ranges::find(bars, model[i], &Series::name);
      if (name[i] == names[n] && largest > 0.0 && bar != bars.end()) bar->y[n] = value[i] / largest;
    }
  }
  Chart chart = barChart("Parameters of all models", names, {"value / largest of the models"}, bars);
  chart.wide = true;
  page.add(std::move(chart));
}

Page make(const ResultFiles& files) {
  if (isRefit(files)) return refitPage(files);
  Page page = beginFitPage(files);
  addTime(files, page);
  addFitDetails(files, page);
  addModels(files, page);
  addBands(files, page);
  addFriction(files, page);
  addMaps(files, page);
  addHistograms(files, page);
  addProfile(files, page);
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/fit-friction/1", make};

}  // namespace simgap::pages::fit_friction
