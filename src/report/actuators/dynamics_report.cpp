#include "simgap/report/actuators/dynamics_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "dynamics_tables.h"
#include "simgap/core/csv.h"
#include "simgap/core/words.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap {
namespace {

using Eigen::Index;

Json jointRecord(const DynamicsReport& report, std::size_t c) {
  const RobotJointLog& joint = report.log.joints[c];
  const DynamicsFit& fit = report.found.fit;
  const bool currents = report.found.model.currents;
  const std::vector<Estimate>& found = report.found.constants;
  return {{"name", joint.name},
          {"effort_unit", joint.effort_unit},
          {"rows", static_cast<long>(fit.rows[c])},
          {"resting", joint.resting},
          {"velocity", joint.measured_velocity ? "measured" : "worked out from the position"},
          {"bandwidth_Hz", numberOrNull(joint.bandwidth)},
          {"noise", numberOrNull(fit.noise[c])},
          {"error_alone", numberOrNull(report.found.heldout.alone[c])},
          {"error_heldout", numberOrNull(report.found.heldout.model[c])},
          {"error_other_logs", report.found.over_logs ? numberOrNull(report.found.over_logs->model[c]) : Json(nullptr)},
          {"error_fitted", numberOrNull(fit.error[c])},
          {"torque_constant_Nm_A", currents ? Json(fit.model.torque_constants[c]) : Json(nullptr)},
          {"torque_constant_sd", found.empty() ? Json(nullptr) : numberOrNull(found[c].sd)},
          {"torque_constant_ci95",
           found.empty() ? Json(nullptr) : Json{numberOrNull(found[c].lower95), numberOrNull(found[c].upper95)}}};
}

Json bodyRecord(const DynamicsReport& report, const RobotRegressor& regressor, const ArmModel& file, std::size_t b) {
  const int body = regressor.dynamics().bodies()[b];
  const Index column = regressor.bodyColumn(b);
  const BodyParameters pi = report.found.fit.model.parameters.segment<kBodyParameters>(column);
  const MassProperties mass = massPropertiesOf(pi), before = massProperties(file.bodies[body]);
  const auto list = [](const Eigen::Vector3d& v) { return Json{v.x(), v.y(), v.z()}; };
  const Eigen::Matrix3d& i = mass.inertia;
  return {{"name", file.bodies[body].name},
          {"mass_in_file_kg", before.mass},
          {"mass_kg", mass.mass},
          {"mass_sd_kg", numberOrNull(report.found.fit.sd[column])},
          {"mass_prior_sd_kg", numberOrNull(report.found.fit.prior_sd[column])},
          {"centre_in_file_m", list(before.centre_of_mass)},
          {"centre_of_mass_m", list(mass.centre_of_mass)},
          {"inertia_kg_m2", {i(0, 0), i(1, 1), i(2, 2), i(0, 1), i(0, 2), i(1, 2)}},
          {"smallest_moment", smallestMoment(pi)}};
}

Json parameterRecords(const DynamicsReport& report, const RobotRegressor& regressor) {
  Json records = Json::array();
  for (Index k = 0; k < regressor.columns(); ++k) {
    const bool body = k >= regressor.bodyColumn(0) && k < regressor.rotorColumn(0);
    const double value = report.found.fit.model.parameters[k], sd = report.found.fit.sd[k];
    records.push_back({{"name", report.found.names[k]},
                       {"unit", report.found.units[k]},
                       {"of", body ? "body" : "drive"},
                       {"value", numberOrNull(value)},
                       {"sd", numberOrNull(sd)},
                       {"prior_sd", numberOrNull(report.found.fit.prior_sd[k])},
                       // Half of what the prior leaves open: what the log has to say is then more than the file's.
                       {"identifiable", sd < 0.5 * report.found.fit.prior_sd[k]}});
  }
  return records;
}

Json baseRecords(const DynamicsReport& report) {
  Json records = Json::array();
  for (const BaseEstimate& base : report.found.fit.base) {
    const Estimate& e = base.estimate;
    records.push_back({{"name", e.name},
                       {"combination", base.text},
                       {"unit", e.unit},
                       {"value", e.identifiable ? numberOrNull(e.value) : Json(nullptr)},
                       {"sd", numberOrNull(e.sd)},
                       {"ci95", {numberOrNull(e.lower95), numberOrNull(e.upper95)}},
                       {"determined", e.identifiable},
                       {"in_file", numberOrNull(base.in_file)},
                       {"in_model", numberOrNull(base.in_model)}});
  }
  return records;
}

/// A stretch of the log, every joint measured and predicted.
std::string dynamicsPredictionsCsv(const DynamicsReport& report) {
  constexpr std::size_t kRows = 4000;
  const std::size_t rows = report.log.rows(), shown = std::min(kRows, rows), begin = (rows - shown) / 2;
  const Eigen::MatrixXd predicted = predictEfforts(report.found.model, report.log);
  std::vector<std::string> header{"time_s"};
  for (const RobotJointLog& joint : report.log.joints) {
    for (const char* what : {"measured", "predicted"}) {
      header.push_back(fmt::format("{}_{}_{}", joint.name, what, joint.effort_unit));
    }
  }
  CsvWriter csv(header);
  for (std::size_t i = begin; i < begin + shown; ++i) {
    csv.add(report.log.time[i]);
    for (std::size_t c = 0; c < report.log.joints.size(); ++c) {
      const double load = report.found.load.empty() ? 0.0 : report.found.load[c][static_cast<Index>(i)];
      csv.add(report.log.joints[c].effort[i]).add(predicted(i, c) + load / report.found.fit.model.torque_constants[c]);
    }
    csv.endRow();
  }
  return csv.text();
}

}  // namespace

Json toJson(const DynamicsReport& report) {
  const RobotRegressor regressor(report.found.model.arm, friction::find(report.found.model.law));
  Json joints = Json::array(), bodies = Json::array();
  for (std::size_t c = 0; c < report.log.joints.size(); ++c) joints.push_back(jointRecord(report, c));
  for (std::size_t b = 0; b < regressor.bodies(); ++b) {
    if (!regressor.massless(b)) bodies.push_back(bodyRecord(report, regressor, report.file, b));
  }
  return {{"format", "simgap/fit-dynamics/1"},
          {"robot", report.found.model.arm.name},
          {"logs", report.log.session_names},
          {"law", report.found.model.law},
          {"n", report.log.rows()},
          {"blocks", report.log.blocks.size()},
          {"inflation", numberOrNull(report.found.fit.inflation)},
          {"converged", report.found.fit.converged},
          {"joints", joints},
          {"bodies", bodies},
          {"parameters", parameterRecords(report, regressor)},
          {"base_parameters", baseRecords(report)},
          {"without_effect", report.found.without_effect},
          {"warnings", report.found.warnings}};
}

std::string terminalTable(const DynamicsReport& report) {
  const Json result = toJson(report);
  std::string text =
      answerText(dynamicsAnswer(result), {dynamicsJoints(result), dynamicsBodies(result), dynamicsDrives(result)});
  for (const std::string& warning : report.found.warnings) text += "note: " + warning + "\n";
  return text;
}

void writeDynamicsReport(const DynamicsReport& report, const RunDirectory& directory) {
  const Json result = toJson(report);
  directory.write("model.yaml", writeRobotModel(report.found.model));
  directory.write("arm.yaml", writeArm(report.found.model.arm));
  directory.write(
      "base_parameters.csv",
      csvText(recordTable("", result.at("base_parameters"),
                          {"name", "combination", "unit", "value", "sd", "determined", "in_file", "in_model"})));
  directory.write("parameters.csv", csvText(recordTable("", result.at("parameters"),
                                                        {"name", "unit", "value", "sd", "prior_sd", "identifiable"})));
  directory.write("predictions.csv", dynamicsPredictionsCsv(report));
}

}  // namespace simgap
