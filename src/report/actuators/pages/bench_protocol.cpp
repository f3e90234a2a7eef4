#include <fmt/format.h>

#include "simgap/core/csv.h"
#include "simgap/report/actuators/protocol_report.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::bench_protocol {
namespace {

Chart overTime(const CsvTable& rows, const char* caption, const std::string& stem, const std::string& unit) {
  Chart chart = lineChart(caption, {"time [s]"}, {fmt::format("[{}]", unitTitle(unit))},
                          {thinned({caption, rows.quantity("time", "s"), rows.quantity(stem, unit)})});
  chart.wide = true;
  makeZoomable(chart);
  return chart;
}

/// Where the log will lie, within the rectangle that the limits allow.
Chart whereRowsLie(const CsvTable& rows, const Json& limits) {
  const double w = numberOf(limits.at("velocity_rad_s")), tau = numberOf(limits.at("torque_Nm"));
  Series points{"rows", rows.quantity("joint_velocity", "rad_s"), rows.quantity("external_torque", "Nm"),
                Series::Style::kPoints};
  const Series box{"limits", {-w, w, w, -w, -w}, {-tau, -tau, tau, tau, -tau}, Series::Style::kDashed};
  const std::size_t stride = 1 + points.x.size() / kMostPoints;
  std::size_t kept = 0;
  for (std::size_t i = 0; i < points.x.size(); i += stride, ++kept) {
    points.x[kept] = points.x[i];
    points.y[kept] = points.y[i];
  }
  points.x.resize(kept);
  points.y.resize(kept);
  return lineChart("Load over velocity", {"velocity of the joint [rad/s]"}, {"load [N m]"}, {points, box});
}

/// Expected deviations of every parameter, relative to random sessions.
Chart deviations(const Json& parameters) {
  std::vector<std::string> names;
  Series here{"this protocol", {}, {}}, random{"sessions at random (median)", {}, {}};
  for (const Json& p : parameters) {
    const double at_random = numberOf(p.at("expected_sd_random"));
    names.push_back(p.at("name"));
    here.y.push_back(numberOf(p.at("expected_sd")) / at_random);
    random.y.push_back(1.0);
  }
  return barChart("Expected standard deviations", names, {"relative to sessions at random"}, {here, random});
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  const CsvTable rows = files.table("protocol.csv");
  Page page{"simgap design --drive", protocolAnswer(result), {}};
  page.verdict =
      PageVerdict{PageVerdict::Level::kGood, "within all limits",
                  "Loads and currents are those of the values given: leave room. Intervals hold for these "
                  "values and the noise stated; design again once a first log is fitted.",
                  fmt::format("simgap fit-friction LOG --ratio {:g}", numberOf(result.at("transmission_ratio")))};
  page.add(overTime(rows, "Position of the joint", "joint_position", "rad"));
  page.add(whereRowsLie(rows, result.at("limits")));
  page.add(deviations(result.at("parameters")));
  for (Table& table : protocolTables(result)) page.add(std::move(table));
  page.addSection("Expected log");
  page.add(overTime(rows, "Load", "external_torque", "Nm"));
  page.add(overTime(rows, "Current", "motor_current", "A"));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/bench-protocol/1", make};

}  // namespace simgap::pages::bench_protocol
