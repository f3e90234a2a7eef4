#include <fmt/format.h>

#include <functional>

#include "simgap/core/rotation.h"
#include "simgap/report/actuators/cable_drive_report.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::simulate_drive {
namespace {

/// A line per compensation; every chart of a page has as many. \param value  of a compensation's name, over the rows
void addChart(const Json& result, const CsvTable& table, const std::string& caption, const std::string& axis,
              const std::vector<Series>& before, const std::function<std::vector<double>(const std::string&)>& value,
              Page& page) {
  const std::vector<double> time = numbersOf(table, "time_s");
  const std::size_t points = pointsPerLine(4 * (result.at("compensations").size() + 1));
  std::vector<Series> lines;
  for (const Series& line : before) lines.push_back(thinned(line, points));
  for (const Json& run : result.at("compensations")) {
    const std::string name = run.at("name").get<std::string>();
    lines.push_back(thinned({name, time, value(name), Series::Style::kLine}, points));
  }
  Chart chart = lineChart(caption, {"time [s]"}, {axis}, lines);
  chart.wide = true;
  makeZoomable(chart);
  page.add(std::move(chart));
}

std::vector<double> scaled(std::vector<double> values, double unit) {
  for (double& value : values) value /= unit;
  return values;
}

std::vector<double> lessWanted(std::vector<double> values, const std::vector<double>& wanted, double unit) {
  for (std::size_t i = 0; i < values.size(); ++i) values[i] = (values[i] - wanted[i]) / unit;
  return values;
}

PageVerdict verdictOf(const Json& result) {
  using enum PageVerdict::Level;
  const std::string step = fmt::format("Steps of half the size change the error without compensation by {:.2g} %.",
                                       numberOf(result.at("half_step_percent")));
  if (!result.at("notes").empty()) return {kDoubtful, "read the notes", step, ""};
  return {kGood, "the step is small enough", step, ""};
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"simgap simulate", cableDriveAnswer(result), result.at("notes").get<std::vector<std::string>>()};
  page.verdict = verdictOf(result);
  page.add(driveTrackingTable(result));
  const CsvTable table = files.table("tracking.csv");
  const bool torque = result.at("commanded") == "torque";
  const std::string reached = torque ? "_torque_Nm" : "_joint_rad";
  const double unit = torque ? 1.0 : kDegree;
  const std::vector<double> time = numbersOf(table, "time_s");
  const std::vector<double> told = numbersOf(table, torque ? "told_Nm" : "reference_rad");
  const auto column = [&](const std::string& name) { return numbersOf(table, name); };
  if (!torque) page.add(driveErrorTable(result));
  addChart(
      result, table, torque ? "Torque in the cable" : "Angle of the joint", torque ? "torque [Nm]" : "angle [deg]",
      {{torque ? "told" : "reference", time, scaled(told, unit), Series::Style::kDashed}},
      [&](const std::string& name) { return scaled(column(name + reached), unit); }, page);
  addChart(
      result, table, "What is missed", torque ? "torque [Nm]" : "angle [deg]", {},
      [&](const std::string& name) { return lessWanted(column(name + reached), told, unit); }, page);
  addChart(
      result, table, "Current", "current [A]", {}, [&](const std::string& name) { return column(name + "_current_A"); },
      page);
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/simulate-drive/1", make};

}  // namespace simgap::pages::simulate_drive
