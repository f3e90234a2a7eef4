#include "response_page.h"

#include <fmt/format.h>

#include <algorithm>

#include "fit_page.h"
#include "simgap/core/units.h"

namespace simgap {

void addResponses(const CsvTable& table, const std::string& measured, const std::string& computed, Page& page) {
  const bool timed = table.has("time_s");
  std::vector<double> x = timed ? numbersOf(table, "time_s") : std::vector<double>(table.rows());
  for (std::size_t i = 0; !timed && i < x.size(); ++i) x[i] = static_cast<double>(i + 1);
  constexpr std::size_t kLines = 3;  // of a quantity: measured, computed, and their difference
  const auto quantities = static_cast<std::size_t>(std::ranges::count_if(
      table.columns(), [&](const std::string& column) { return splitUnit(column).stem.ends_with(computed); }));
  const std::size_t most = pointsPerLine(kLines * quantities);
  for (const std::string& column : table.columns()) {
    const UnitName name = splitUnit(column);
    if (!name.stem.ends_with(computed)) continue;
    const std::string quantity = name.stem.substr(0, name.stem.size() - computed.size());
    std::vector<Series> lines;
    const std::string other = quantityName(quantity + measured, name.unit);
    if (table.has(other))
      lines.push_back(
          thinned({measured.substr(1), x, numbersOf(table, other), Series::Style::kLine, 6, /*faint=*/true}, most));
    lines.push_back(thinned({computed.substr(1), x, numbersOf(table, column), Series::Style::kLine, 0}, most));
    Chart chart = lineChart(quantity + (timed ? " over time" : " of every row"), {timed ? "time [s]" : "row"},
                            {axisTitle(quantityName(quantity, name.unit))}, lines);
    chart.wide = true;
    makeZoomable(chart);
    page.add(std::move(chart));
    if (!table.has(other)) continue;
    Chart residual = residualChart(x, numbersOf(table, other), {{computed.substr(1), numbersOf(table, column)}},
                                   axisTitle(quantityName(quantity, name.unit)), most);
    residual.caption = fmt::format("{}: {} - {}", quantity, computed.substr(1), measured.substr(1));
    page.add(std::move(residual));
  }
}

Page driveFitPage(const ResultFiles& files) {
  if (isRefit(files)) return refitPage(files);
  Page page = beginFitPage(files);
  addResponses(files.table("response.csv"), "_measured", "_simulated", page);
  addFitDetails(files, page);
  return page;
}

}  // namespace simgap
