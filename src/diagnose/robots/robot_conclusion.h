/// \file
/// The answer about a robot in words, and as a robot.
#pragma once

#include "robot_selection.h"
#include "simgap/diagnose/robots/robot_diagnosis.h"

namespace simgap {

/// Verdict, sentence, what to record next, from all that has been found besides.
void concludeRobot(const RobotSearch& search, const RobotSelection& selection, RobotDiagnosis& result);

/// Causes that this log could not have shown, and why. \param known  base parameters were known before it
void addUntestable(const RobotSearch& search, bool known, Diagnosis& d);
/// The smallest size of each cause with one number that these blocks could have shown.
void addDetectable(const RobotSearch& search, const RobotSelection& selection, const RobotDiagnosisOptions& options,
                   Diagnosis& d);

/// Puts a cause into a robot. \param covariance  of theta, shape (C, C) \returns false where its file cannot hold it,
/// or no such body can exist; the robot is then as it was
bool holdCause(const RobotRegressor& regressor, const BaseParameters& base, const RobotHypothesis& hypothesis,
               const Eigen::VectorXd& theta, const Eigen::MatrixXd& covariance, RobotModel& robot);

}  // namespace simgap
