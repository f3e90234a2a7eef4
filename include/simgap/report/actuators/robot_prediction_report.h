/// \file
/// What `predict` shows and writes for a robot: the effort of every joint.
#pragma once

#include <Eigen/Core>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/fit/dynamics/robot_model.h"

namespace simgap {

struct RobotPrediction {
  RobotLog log;
  Eigen::MatrixXd predicted;  ///< shape (rows, N), in the log's unit
  std::vector<double> error;  ///< shape (N): relative, over rows in which the joint moves
  double error_of_all = 0.0;  ///< the same of all joints, each with the weight of its own effort
};

/// \throws DataError: the model predicts torques and the log holds currents, or the other way round
RobotPrediction predictRobot(const RobotModel& model, RobotLog log);

Json toJson(const RobotPrediction& prediction);
std::string predictionCsv(const RobotPrediction& prediction);
/// \param file  where the CSV went
std::string terminalTable(const RobotPrediction& prediction, const std::string& file);

}  // namespace simgap
