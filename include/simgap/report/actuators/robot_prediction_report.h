/// \file
/// What `predict` shows and writes for a robot: the effort of every joint, or its motion under the efforts of the log.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/fit/dynamics/robot_free_run.h"
#include "simgap/fit/dynamics/robot_model.h"

namespace simgap {

struct RobotPrediction {
  RobotLog log;
  Eigen::MatrixXd predicted;  ///< shape (rows, N), in the log's unit
  std::vector<double> error;  ///< shape (N): relative, over rows in which the joint moves
  double error_of_all = 0.0;  ///< the same of all joints, each with the weight of its own effort
};

/// A robot played freely.
struct RobotMotionPrediction {
  RobotLog log;
  RobotFreeRun run;
  bool controlled = false;  ///< gains of its controllers were given
};

/// \throws DataError: the model predicts torques and the log holds currents, or the other way round
void requireSameEffort(const RobotModel& model, const RobotLog& log);
/// \throws DataError as requireSameEffort
RobotPrediction predictRobot(const RobotModel& model, RobotLog log);

Json toJson(const RobotPrediction& prediction);
Json toJson(const RobotMotionPrediction& prediction);
std::string predictionCsv(const RobotPrediction& prediction);
std::string predictionCsv(const RobotMotionPrediction& prediction);
/// \param file  where the CSV went
std::string terminalTable(const RobotPrediction& prediction, const std::string& file);
std::string terminalTable(const RobotMotionPrediction& prediction, const std::string& file);

}  // namespace simgap
