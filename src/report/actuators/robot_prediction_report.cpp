#include "simgap/report/actuators/robot_prediction_report.h"

#include <fmt/format.h>

#include <cmath>

#include "dynamics_tables.h"
#include "simgap/core/csv.h"
#include "simgap/core/error.h"

namespace simgap {

RobotPrediction predictRobot(const RobotModel& model, RobotLog log) {
  const bool currents = log.joints.front().effort_unit == "A";
  if (currents != model.currents) {
    throw DataError(fmt::format("{}: found {}, expected the {} that the model predicts", log.file,
                                currents ? "currents" : "torques", model.currents ? "currents" : "torques"));
  }
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

std::string predictionCsv(const RobotPrediction& p) {
  std::vector<std::string> header{"time_s"};
  for (const RobotJointLog& joint : p.log.joints) {
    for (const char* what : {"predicted", "measured"}) {
      header.push_back(fmt::format("{}_{}_{}", joint.name, what, joint.effort_unit));
    }
  }
  CsvWriter csv(header);
  for (std::size_t i = 0; i < p.log.rows(); ++i) {
    csv.add(p.log.time[i]);
    for (std::size_t c = 0; c < p.log.joints.size(); ++c) {
      csv.add(p.predicted(i, c)).add(p.log.joints[c].effort[i]);
    }
    csv.endRow();
  }
  return csv.text();
}

std::string terminalTable(const RobotPrediction& p, const std::string& file) {
  const Json result = toJson(p);
  std::string text =
      fmt::format("efforts of {} joints predicted for {} rows: {}\n", p.log.joints.size(), p.log.rows(), file);
  text += alignedTable(robotPredictionJoints(result));
  for (const std::string& warning : p.log.warnings) text += "note: " + warning + "\n";
  return text;
}

}  // namespace simgap
