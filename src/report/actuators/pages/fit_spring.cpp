#include <algorithm>

#include "report/actuators/fit_page.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages {
namespace {

/// One series of a table per name; what was measured, and what is missed, as points.
std::vector<Series> springSeries(const CsvTable& table, const std::string& x, const std::string& y, bool points) {
  std::vector<Series> lines;
  for (const std::string& name : distinctOf(table, "series")) {
    lines.push_back({name, numbersWhere(table, x, "series", name), numbersWhere(table, y, "series", name)});
    if (points || name == "measured") lines.back().style = Series::Style::kPoints;
    if (name == "measured") lines.back().colour = 6;
  }
  return lines;
}

Page make(const ResultFiles& files) {
  if (isRefit(files)) return refitPage(files);
  Page page = beginFitPage(files);
  const CsvTable forces = files.table("forces.csv"), errors = files.table("errors.csv");
  const std::string deflection = columnLike(forces, "deflection"), error = columnLike(errors, "error");
  const std::string force = forces.columns().back(), time = errors.columns()[1];
  Chart curve = lineChart("Force over deflection", {axisTitle(deflection)}, {axisTitle(force)},
                          springSeries(forces, deflection, force, false));
  curve.wide = true;
  page.add(std::move(curve));
  page.add(lineChart("Error over deflection", {axisTitle(deflection)}, {"predicted - measured"},
                     springSeries(errors, deflection, error, true)));
  page.add(lineChart("Error over time", {axisTitle(time)}, {"predicted - measured"},
                     springSeries(errors, time, error, true)));
  addFitDetails(files, page);
  return page;
}

}  // namespace

extern const ResultPage fit_spring;
const ResultPage fit_spring{"simgap/fit-spring/1", make};

}  // namespace simgap::pages
