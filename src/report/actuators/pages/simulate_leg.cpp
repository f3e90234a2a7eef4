#include <fmt/format.h>

#include "simgap/report/actuators/exo_leg_report.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::simulate_leg {
namespace {

Chart overTime(const std::string& caption, const std::string& axis, std::vector<Series> lines) {
  Chart chart = lineChart(caption, {"time [s]"}, {axis}, std::move(lines));
  chart.wide = true;
  makeZoomable(chart);
  return chart;
}

/// Good where the hip is lifted for more of the time with the exoskeleton than without.
PageVerdict verdictOf(const Json& result) {
  using enum PageVerdict::Level;
  const double assisted = numberOf(result.at("runs").at(0).at("obeyed_share"));
  const double alone = numberOf(result.at("runs").at(1).at("obeyed_share"));
  const std::string step =
      fmt::format("Steps of half the size move the hip by {:.2g} mm at most.", numberOf(result.at("half_step_mm")));
  if (!(assisted > alone)) return {kDoubtful, "the exoskeleton does not help", step, ""};
  return {kGood, "the exoskeleton helps", step, ""};
}

Page make(const ResultFiles& files) {
  Page page{"simgap simulate", exoLegAnswer(files.result()) + ".", {}};
  page.verdict = verdictOf(files.result());
  const CsvTable table = files.table("motion.csv");
  const std::vector<double> time = numbersOf(table, "time_s");
  const auto line = [&](const char* name, const char* column, Series::Style style = Series::Style::kLine) {
    return thinned({name, time, numbersOf(table, column), style});
  };
  page.add(overTime("Told to be up", "1: up", {line("told", "told_up")}));
  page.add(overTime(
      "Hip", "height [m]",
      {line("with the exoskeleton", "hip_height_m"), line("alone", "hip_height_alone_m", Series::Style::kDashed)}));
  page.add(exoLegTable(files.result()));
  page.add(overTime("Torques of the exoskeleton", "torque [Nm]",
                    {line("ankle", "ankle_assist_Nm"), line("knee", "knee_assist_Nm")}));
  page.add(overTime("Joints", "angle [rad]", {line("ankle", "ankle_rad"), line("knee", "knee_rad")}));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/simulate-leg/1", make};

}  // namespace simgap::pages::simulate_leg
