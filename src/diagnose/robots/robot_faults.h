/// \file
/// What is wrong with a robot's log before any physics.
#pragma once

#include <vector>

#include "simgap/diagnose/diagnosis.h"
#include "simgap/fit/dynamics/dynamics_fit.h"

namespace simgap {

/// Efforts of one joint that stand still while it moves, and of a known robot efforts with the opposite sign. Rows in
/// which an effort is cut off are left out of `log` and said. \param given  shape (P): of a known robot; empty
/// otherwise
std::vector<DataFault> findRobotFaults(const RobotRegressor& regressor, const Eigen::VectorXd& given,
                                       const std::vector<StribeckCurve>& curves, RobotLog& log);

/// \throws DataError: the robot says less of the efforts of most joints than nothing would.
void requireLogOfRobot(const DynamicsData& data, const std::vector<JointSums>& sums, const Eigen::VectorXd& given,
                       const std::vector<double>& constants, const std::string& file);

}  // namespace simgap
