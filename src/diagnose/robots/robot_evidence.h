/// \file
/// What a robot's model with its causes says of every row, and the residual of its joints against what drives them.
#pragma once

#include "robot_findings.h"

namespace simgap {

/// Base parameters as the regressor's own, shape (P): only what is kept has a value. \param z  begins with them
Eigen::VectorXd keptParameters(const RobotRegressor& regressor, const BaseParameters& base, const Eigen::VectorXd& z);

/// Torque of every joint, shape (rows, N), of a fit to all training blocks.
Eigen::MatrixXd predictedTorque(const RobotSearch& search, const RobotSearch::Set& set, const RobotSearch::Fit& fit);

/// Mean residuals, before and after, of the joints on which causes act (of all without causes): against what each cause
/// adds, and the joint's position, velocity, acceleration, load and time. \param before, after  shape (rows, N) of
/// torques
std::vector<EvidenceBin> robotEvidence(const RobotSearch& search, const RobotSearch::Set& set,
                                       const RobotSearch::Fit& fit, const Eigen::MatrixXd& before,
                                       const Eigen::MatrixXd& after);

/// Mean squared error between neighbours, each joint's over its variance: no model can go below it. Shape (N + 1): of
/// each joint, and of all rows of all joints.
std::vector<double> noiseFloors(const RobotSearch& search, const Eigen::MatrixXd& predicted);

/// The squared error of a joint that is no news, over its variance: what was left of it on data that the robot was not
/// fitted to when it was found (RobotModel::heldout_sd), or the noise between neighbouring rows where that is more, as
/// of noise that grows with the effort; nan where nobody has written the first down. \param floor  of noiseFloors
double knownError(const RobotSearch& search, double floor, std::size_t joint);

}  // namespace simgap
