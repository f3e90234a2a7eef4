#include <fmt/format.h>

#include "simgap/core/csv.h"
#include "simgap/report/actuators/excitation_report.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::excitation {
namespace {

/// Every joint over one period.
Chart motionChart(const ResultFiles& files, const char* caption, const std::string& quantity, const std::string& unit) {
  const CsvTable table = files.table("trajectory.csv");
  const std::vector<double> time = table.quantity("time", "s");
  std::vector<Series> lines;
  for (const Json& joint : files.result().at("joints")) {
    if (joint.at("unit") != "rad") continue;
    const std::string name = joint.at("name");
    lines.push_back(thinned({name, time, table.quantity(name + quantity, unit)}));
  }
  Chart chart = lineChart(caption, {"time [s]"}, {fmt::format("[{}]", unitTitle(unit))}, lines);
  chart.wide = true;
  return chart;
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"simgap design --excite", excitationAnswer(result), {}};
  page.verdict = PageVerdict{PageVerdict::Level::kGood, "within all limits",
                             "Efforts are those of the masses and frictions in the robot's file: leave room.",
                             "simgap fit-dynamics ROBOT --log LOG"};
  page.add(motionChart(files, "Positions", "", "rad"));
  page.add(motionChart(files, "Speeds", "_velocity", "rad_s"));
  for (Table& table : excitationTables(result)) page.add(std::move(table));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/excitation/1", make};

}  // namespace simgap::pages::excitation
