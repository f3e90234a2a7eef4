#include "report/actuators/fit_page.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::fit_spring {
namespace {

/// The same lines as points, as many as an eye can tell apart.
std::vector<Series> asPoints(std::vector<Series> lines) {
  constexpr std::size_t kPoints = 800;
  for (Series& line : lines) {
    line = thinned(line, kPoints);
    line.style = Series::Style::kPoints;
  }
  return lines;
}

Page make(const ResultFiles& files) {
  if (isRefit(files)) return refitPage(files);
  Page page = beginFitPage(files);
  const CsvTable forces = files.table("forces.csv"), errors = files.table("errors.csv");
  const std::string deflection = columnLike(forces, "deflection"), error = columnLike(errors, "error");
  const std::string force = forces.columns().back(), time = errors.columns().at(1);
  Chart curve = lineChart("Force over deflection", {axisTitle(deflection)}, {axisTitle(force)},
                          seriesOf(forces, deflection, force));
  curve.wide = true;
  page.add(std::move(curve));
  page.add(lineChart("Error over deflection", {axisTitle(deflection)}, {"predicted - measured"},
                     asPoints(seriesOf(errors, deflection, error))));
  page.add(lineChart("Error over time", {axisTitle(time)}, {"predicted - measured"},
                     asPoints(seriesOf(errors, time, error))));
  addFitDetails(files, page);
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/fit-spring/1", make};

}  // namespace simgap::pages::fit_spring
