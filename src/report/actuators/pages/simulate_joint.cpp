#include <fmt/format.h>

#include "simgap/report/actuators/exo_joint_report.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::simulate_joint {
namespace {

struct Curve {
  const char* column;
  const char* name;
  Series::Style style = Series::Style::kLine;
};

constexpr std::size_t kLinesOfAPage = 14;

void addCurves(const CsvTable& table, const std::string& caption, const std::string& axis,
               std::initializer_list<Curve> curves, Page& page) {
  const std::vector<double> time = numbersOf(table, "time_s");
  std::vector<Series> lines;
  for (const Curve& curve : curves) {
    if (table.has(curve.column))
      lines.push_back(
          thinned({curve.name, time, numbersOf(table, curve.column), curve.style}, pointsPerLine(kLinesOfAPage)));
  }
  Chart chart = lineChart(caption, {"time [s]"}, {axis}, lines);
  chart.wide = true;
  makeZoomable(chart);
  page.add(std::move(chart));
}

void addTracking(const ResultFiles& files, Page& page) {
  if (!files.has("tracking.csv")) return;
  const CsvTable table = files.table("tracking.csv");
  addCurves(table, "Torque of the muscles alone (002 fig. 8)", "torque [Nm]",
            {{"desired_Nm", "desired", Series::Style::kDashed},
             {"tendon_alone_Nm", "tendons in the controller"},
             {"rigid_alone_Nm", "no tendons in the controller"}},
            page);
  if (table.has("tendon_motor_Nm")) {
    addCurves(table, "Torque with the motor", "torque [Nm]",
              {{"desired_Nm", "desired", Series::Style::kDashed},
               {"tendon_motor_Nm", "tendons in the controller"},
               {"rigid_motor_Nm", "no tendons in the controller"}},
              page);
  }
  page.add(exoControllerTable(files.result()));
}

PageVerdict verdictOf(const Json& result) {
  using enum PageVerdict::Level;
  const std::string step =
      fmt::format("Steps of half the size move the joint by {:.2g} deg at most.", numberOf(result.at("half_step_deg")));
  if (!result.at("notes").empty()) return {kDoubtful, "read the notes", step, ""};
  return {kGood, "the step is small enough", step, ""};
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"simgap simulate", exoJointAnswer(result) + ".", result.at("notes").get<std::vector<std::string>>()};
  page.verdict = verdictOf(result);
  addTracking(files, page);
  const CsvTable motion = files.table("motion.csv");
  addCurves(motion, "Joint", "angle [rad]", {{"angle_rad", "angle"}}, page);
  addCurves(motion, "Torques", "torque [Nm]",
            {{"muscle_torque_Nm", "muscles"}, {"motor_torque_Nm", "motor"}, {"missing_torque_Nm", "missing"}}, page);
  addCurves(motion, "Pressures in the muscles", "pressure [Pa]",
            {{"pressure_flexor_Pa", "flexor"}, {"pressure_extensor_Pa", "extensor"}}, page);
  addCurves(motion, "Tension of the muscles", "tension [N]",
            {{"tension_flexor_N", "flexor"}, {"tension_extensor_N", "extensor"}}, page);
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/simulate-joint/1", make};

}  // namespace simgap::pages::simulate_joint
