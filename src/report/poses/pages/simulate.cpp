#include <fmt/format.h>

#include "report/poses/arm_scene.h"
#include "simgap/core/units.h"
#include "simgap/report/html/result_page.h"
#include "simgap/report/poses/simulation_report.h"

namespace simgap::pages::simulate {
namespace {

PageVerdict verdictOf(const Json& result) {
  using enum PageVerdict::Level;
  const std::string speed = fmt::format("{:.0f} times as fast as real time.", numberOf(result.at("real_time_factor")));
  if (!result.at("notes").empty()) return {kDoubtful, "read the notes", speed, ""};
  return {kGood, "the step is small enough", speed, ""};
}

std::vector<ScenePose> frames(const ResultFiles& files) {
  std::vector<ScenePose> poses;
  for (const std::string& name : distinctOf(files.table("arm_bodies.csv"), "pose")) {
    poses.push_back({"motion", name, {{"simulated", ""}}});
  }
  return poses;
}

/// Columns PREFIX…SUFFIX over time, one line each.
void addChart(const CsvTable& table, const std::string& caption, const std::string& prefix, const std::string& suffix,
              const std::string& axis, Page& page) {
  std::vector<Series> lines;
  for (const std::string& column : table.columns()) {
    if (!column.starts_with(prefix) || !column.ends_with(suffix)) continue;
    const std::string name = column.substr(prefix.size(), column.size() - prefix.size() - suffix.size());
    lines.push_back(thinned({name, numbersOf(table, "time_s"), numbersOf(table, column), Series::Style::kLine}));
  }
  if (lines.empty()) return;
  Chart chart = lineChart(caption, {"time [s]"}, {axis}, lines);
  chart.wide = true;
  makeZoomable(chart);
  page.add(std::move(chart));
}

/// Where joints are over time, from the columns of motion.csv that end so.
void addPositions(const ResultFiles& files, const std::string& caption, std::initializer_list<const char*> suffixes,
                  const std::string& axis, Page& page) {
  const CsvTable table = files.table("motion.csv");
  std::vector<Series> lines;
  for (const auto& [joint, _] : files.result().at("joints").items()) {
    for (const char* suffix : suffixes) {
      if (!table.has(joint + suffix)) continue;
      lines.push_back(thinned({joint + suffix, numbersOf(table, "time_s"), numbersOf(table, joint + suffix)}));
    }
  }
  if (lines.empty()) return;
  Chart chart = lineChart(caption, {"time [s]"}, {axis}, lines);
  chart.wide = true;
  makeZoomable(chart);
  page.add(std::move(chart));
}

/// Of hinges: of a ball joint no single angle says where it is.
void addJoints(const ResultFiles& files, Page& page) {
  if (files.has("measured.csv")) {
    const CsvTable table = files.table("measured.csv");
    addChart(table, "Joints, simulated", "", "_simulated_deg", "angle from the zero pose [deg]", page);
    addChart(table, "Joints, measured", "", "_measured_deg", "angle from the zero pose [deg]", page);
    addChart(table, "Joints: simulated to measured", "", "_error_deg", "error [deg]", page);
    addChart(table, "Slides, simulated", "", "_simulated_mm", "way from the zero pose [mm]", page);
    addChart(table, "Slides, measured", "", "_measured_mm", "way from the zero pose [mm]", page);
    addChart(table, "Slides: simulated to measured", "", "_error_mm", "error [mm]", page);
    return;
  }
  addPositions(files, "Joints", {"_rad", "_qx", "_qy", "_qz"}, "angle [rad], or part of a quaternion", page);
  addPositions(files, "Slides", {"_m"}, "way [m]", page);
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  const double duration = numberOf(result.at("end_s")) - numberOf(result.at("start_s"));
  Page page{"simgap simulate",
            fmt::format("{:g} s of {} under its commands.", duration, result.at("arm").get<std::string>()),
            result.at("notes").get<std::vector<std::string>>()};
  page.verdict = verdictOf(result);
  const bool measured = !result.at("measured").is_null();
  if (auto scene = armScene(files, frames(files), SceneMotion{duration, measured})) page.add(std::move(*scene));
  addJoints(files, page);
  const CsvTable motion = files.table("motion.csv");
  addChart(motion, "Tension of the cords", "tension_", "_N", "tension [N]", page);
  addChart(motion, "Shafts", "shaft_", "_rad", "shaft angle [rad]", page);
  addChart(motion, "Motor currents", "current_", "_A", "current [A]", page);
  addChart(motion, "Motor voltages", "voltage_", "_V", "voltage [V]", page);
  addChart(motion, "Pressures in muscles", "pressure_", "_Pa", "pressure [Pa]", page);
  addChart(motion, "Torques of motors and servos at joints", "torque_", "_Nm", "torque [Nm]", page);
  page.addSection("Numbers");
  page.add(jointMotionTable(result));
  if (!result.at("muscles").empty()) page.add(muscleMotionTable(result));
  if (const Table drives = lineMotionTable(result); !drives.rows.empty()) page.add(drives);
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/simulate/1", make};

}  // namespace simgap::pages::simulate
