#include "simgap/report/actuators/robot_prediction_report.h"

#include <fmt/format.h>

#include <cmath>

#include "dynamics_tables.h"
#include "simgap/core/csv.h"
#include "simgap/core/error.h"

namespace simgap {

namespace {

/// Columns "J_predicted_U", "J_measured_U" of every joint.
template <class Unit, class Value>
std::string columnsOf(const RobotLog& log, Unit unit, Value value) {
  std::vector<std::string> header{"time_s"};
  for (std::size_t c = 0; c < log.joints.size(); ++c) {
    for (const char* what : {"predicted", "measured"}) {
      header.push_back(fmt::format("{}_{}_{}", log.joints[c].name, what, unit(c)));
    }
  }
  CsvWriter csv(header);
  for (std::size_t i = 0; i < log.rows(); ++i) {
    csv.add(log.time[i]);
    for (std::size_t c = 0; c < log.joints.size(); ++c) {
      const auto [predicted, measured] = value(i, c);
      csv.add(predicted).add(measured);
    }
    csv.endRow();
  }
  return csv.text();
}

const char* positionUnit(const RobotJointLog& joint) { return joint.slides ? "m" : "rad"; }

}  // namespace

void requireSameEffort(const RobotModel& model, const RobotLog& log) {
  const bool currents = log.joints.front().effort_unit == "A";
  if (currents == model.currents) return;
  throw DataError(fmt::format("{}: found {}, expected the {} that the model predicts", log.file,
                              currents ? "currents" : "torques", model.currents ? "currents" : "torques"));
}

RobotPrediction predictRobot(const RobotModel& model, RobotLog log) {
  requireSameEffort(model, log);
  RobotPrediction prediction{std::move(log), {}, {}};
  prediction.predicted = predictEfforts(model, prediction.log);
  double sum = 0.0, joints = 0.0;
  for (std::size_t c = 0; c < prediction.log.joints.size(); ++c) {
    const double error = relativeError(prediction.log, c, prediction.predicted);
    prediction.error.push_back(error);
    if (!std::isfinite(error)) continue;
    sum += error * error;
    ++joints;
  }
  prediction.error_of_all = joints > 0.0 ? std::sqrt(sum / joints) : std::nan("");
  return prediction;
}

Json toJson(const RobotPrediction& p) {
  Json joints = Json::array();
  for (std::size_t c = 0; c < p.log.joints.size(); ++c) {
    const RobotJointLog& joint = p.log.joints[c];
    joints.push_back({{"name", joint.name},
                      {"effort_unit", joint.effort_unit},
                      {"resting", joint.resting},
                      {"relative_error", numberOrNull(p.error[c])}});
  }
  const bool currents = p.log.joints.front().effort_unit == "A";
  return {{"format", "simgap/predict/1"},
          {"model", "robot"},
          {"predicts", currents ? "current_A" : "torque_Nm"},
          {"rows", p.log.rows()},
          {"left_out", 0},
          {"rms_error", nullptr},
          {"relative_error", numberOrNull(p.error_of_all)},
          {"joints", joints},
          {"warnings", p.log.warnings}};
}

Json toJson(const RobotMotionPrediction& p) {
  Json joints = Json::array();
  std::vector<std::string> warnings = p.log.warnings;
  for (std::size_t c = 0; c < p.log.joints.size(); ++c) {
    const double range = p.run.range[c];
    joints.push_back({{"name", p.log.joints[c].name},
                      {"unit", positionUnit(p.log.joints[c])},
                      {"rms_error", numberOrNull(p.run.rms[c])},
                      {"range", numberOrNull(range)},
                      {"half_step_rms", numberOrNull(p.run.half_step[c])},
                      {"near_s", numberOrNull(p.run.near_s[c])},
                      {"beyond_limit", numberOrNull(p.run.beyond_limit[c])}});
    if (p.run.beyond_limit[c] == 0.0) continue;
    warnings.push_back(fmt::format("{} goes {:.3g} {} beyond its limits, which are no stops here", p.log.joints[c].name,
                                   p.run.beyond_limit[c], positionUnit(p.log.joints[c])));
  }
  return {{"format", "simgap/predict/1"}, {"model", "robot"}, {"predicts", "position"},
          {"rows", p.log.rows()},         {"left_out", 0},    {"rms_error", nullptr},
          {"controlled", p.controlled},   {"joints", joints}, {"warnings", warnings}};
}

std::string predictionCsv(const RobotPrediction& p) {
  return columnsOf(
      p.log, [&](std::size_t c) { return p.log.joints[c].effort_unit; },
      [&](std::size_t i, std::size_t c) { return std::pair(p.predicted(i, c), p.log.joints[c].effort[i]); });
}

std::string predictionCsv(const RobotMotionPrediction& p) {
  return columnsOf(
      p.log, [&](std::size_t c) { return positionUnit(p.log.joints[c]); },
      [&](std::size_t i, std::size_t c) { return std::pair(p.run.position(i, c), p.log.joints[c].position[i]); });
}

std::string terminalTable(const RobotPrediction& p, const std::string& file) {
  const Json result = toJson(p);
  std::string text =
      fmt::format("efforts of {} joints predicted for {} rows: {}\n", p.log.joints.size(), p.log.rows(), file);
  text += alignedTable(robotPredictionJoints(result));
  for (const std::string& warning : p.log.warnings) text += "note: " + warning + "\n";
  return text;
}

std::string terminalTable(const RobotMotionPrediction& p, const std::string& file) {
  const Json result = toJson(p);
  std::string text = robotMotionAnswer(result) + "\n" + alignedTable(robotMotionJoints(result)) + file + "\n";
  for (const Json& warning : result.at("warnings")) text += "note: " + warning.get<std::string>() + "\n";
  return text;
}

}  // namespace simgap
