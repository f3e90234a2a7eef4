#include "dynamics_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/report/actuators/fit_report.h"

namespace simgap {
namespace {

std::string percentCell(const Json& share) {
  const double value = numberOf(share);
  return std::isfinite(value) ? fmt::format("{:.3g} %", 100.0 * value) : "-";
}

std::string rangeText(const Json& joints, const char* key) {
  double lowest = INFINITY, highest = 0.0;
  for (const Json& joint : joints) {
    const double error = numberOf(joint.at(key));
    if (!std::isfinite(error)) continue;
    lowest = std::min(lowest, error);
    highest = std::max(highest, error);
  }
  if (lowest > highest) return "-";
  return fmt::format("{:.3g} to {:.3g} %", 100.0 * lowest, 100.0 * highest);
}

std::string spread(const Json& value, const Json& sd) {
  return fmt::format("{} ± {}", valueText(numberOf(value), numberOf(sd)), numberText(sd, "{:.2g}"));
}

}  // namespace

std::string dynamicsAnswer(const Json& result) {
  const Json& joints = result.at("joints");
  return fmt::format(
      "All joints at once leave {} of a joint's effort on blocks that the fit has not seen; each joint alone, with its "
      "own friction and offset, {}.",
      rangeText(joints, "error_heldout"), rangeText(joints, "error_alone"));
}

Table dynamicsJoints(const Json& result) {
  const bool logs = result.at("logs").size() > 1;
  Table table{"Joints (errors relative to the effort, on rows held out)",
              {"joint", "rows", "at rest", "alone", "all joints"},
              {}};
  if (logs) table.header.emplace_back("other logs");
  table.header.insert(table.header.end(), {"fitted", "noise"});
  for (const Json& joint : result.at("joints")) {
    std::vector<std::string> row = {joint.at("name"), joint.at("rows").dump(), joint.at("resting").dump(),
                                    percentCell(joint.at("error_alone")), percentCell(joint.at("error_heldout"))};
    if (logs) row.push_back(percentCell(joint.at("error_other_logs")));
    row.push_back(percentCell(joint.at("error_fitted")));
    row.push_back(numberText(joint.at("noise"), "{:.3g}") + " " + joint.at("effort_unit").get<std::string>());
    table.rows.push_back(std::move(row));
  }
  return table;
}

Table robotPredictionJoints(const Json& result) {
  Table table{"Errors relative to the measured effort", {"joint", "error", "rows at rest"}, {}};
  for (const Json& joint : result.at("joints")) {
    table.rows.push_back({joint.at("name"), percentCell(joint.at("relative_error")), joint.at("resting").dump()});
  }
  table.rows.push_back({"all", percentCell(result.at("relative_error")), ""});
  return table;
}

std::string robotMotionAnswer(const Json& result) {
  double worst = 0.0;
  std::string joint;
  for (const Json& j : result.at("joints")) {
    const double range = numberOf(j.at("range")), share = numberOf(j.at("rms_error")) / range;
    if (range > 0.0 && share > worst) worst = share, joint = j.at("name").get<std::string>();
  }
  return fmt::format(
      "The motion under the efforts of the log{}: {} is off most, by {:.3g} % of its range (RMS).",
      result.at("controlled").get<bool>() ? " and the controllers' gains" : ", told only where it begins",
      joint.empty() ? "no joint" : joint, 100.0 * worst);
}

Table robotMotionJoints(const Json& result) {
  Table table{"Free motion against the log (near: within a tenth of the range; half step: what half the step changes)",
              {"joint", "unit", "RMS error", "range", "near for [s]", "half step"},
              {}};
  for (const Json& joint : result.at("joints")) {
    table.rows.push_back({joint.at("name"), joint.at("unit"), numberText(joint.at("rms_error"), "{:.3g}"),
                          numberText(joint.at("range"), "{:.3g}"), numberText(joint.at("near_s"), "{:.3g}"),
                          numberText(joint.at("half_step_rms"), "{:.2g}")});
  }
  return table;
}

Table dynamicsBodies(const Json& result) {
  Table table{"Bodies (of the file, and as found with the file as prior)",
              {"body", "mass in file [kg]", "mass [kg]", "centre of mass [m]"},
              {}};
  for (const Json& body : result.at("bodies")) {
    const Json& centre = body.at("centre_of_mass_m");
    table.rows.push_back(
        {body.at("name"), numberText(body.at("mass_in_file_kg"), "{:.4g}"),
         spread(body.at("mass_kg"), body.at("mass_sd_kg")),
         fmt::format("{:.3f}, {:.3f}, {:.3f}", numberOf(centre[0]), numberOf(centre[1]), numberOf(centre[2]))});
  }
  return table;
}

Table dynamicsDrives(const Json& result) {
  Table table{"Drives", {"parameter", "unit", "value", "sd"}, {}};
  for (const Json& p : result.at("parameters")) {
    if (p.at("of") == "body") continue;
    table.rows.push_back({p.at("name"), unitTitle(p.at("unit")),
                          valueText(numberOf(p.at("value")), numberOf(p.at("sd"))), numberText(p.at("sd"), "{:.2g}")});
  }
  for (const Json& joint : result.at("joints")) {
    if (joint.at("torque_constant_Nm_A").is_null()) continue;
    table.rows.push_back(
        {joint.at("name").get<std::string>() + ".torque_constant", "Nm/A",
         numberText(joint.at("torque_constant_Nm_A"), "{:.4g}"),
         joint.at("torque_constant_sd").is_null() ? "given" : numberText(joint.at("torque_constant_sd"), "{:.2g}")});
  }
  return table;
}

Table dynamicsBase(const Json& result) {
  Table table{"Base parameters: what motions can tell apart (of the log alone)",
              {"parameter", "unit", "value", "95 % interval", "bodies in file"},
              {}};
  for (const Json& p : result.at("base_parameters")) {
    const double sd = numberOf(p.at("sd"));
    const bool known = p.at("determined");
    table.rows.push_back({p.at("combination"), unitTitle(p.at("unit")),
                          known ? valueText(numberOf(p.at("value")), sd) : "not determined",
                          known ? fmt::format("{} … {}", valueText(numberOf(p.at("ci95").at(0)), sd),
                                              valueText(numberOf(p.at("ci95").at(1)), sd))
                                : "-",
                          numberText(p.at("in_file"), "{:.4g}")});
  }
  table.folded = true;
  return table;
}

}  // namespace simgap
