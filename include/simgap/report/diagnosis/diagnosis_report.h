/// \file
/// The answer of `diagnose` as JSON (docs/formats.md), CSV and one screen for the terminal.
#pragma once

#include <string>

#include "simgap/core/run_directory.h"
#include "simgap/diagnose/logs/refitted_model.h"
#include "simgap/diagnose/motions/motion_diagnosis.h"
#include "simgap/diagnose/poses/pose_diagnosis.h"
#include "simgap/diagnose/robots/robot_diagnosis.h"

namespace simgap {

Json toJson(const Diagnosis& diagnosis);
std::string hypothesesCsv(const Diagnosis& diagnosis);
std::string evidenceCsv(const Diagnosis& diagnosis);
std::string terminalTable(const Diagnosis& diagnosis);

/// baseline.yaml, model.yaml, predictions.csv, the tables of hypotheses and evidence, and one residual_<channel>.csv
/// per channel that what is left depends on; nothing when the log could not be fitted. \param given, source  as
/// refittedModel: the user's file, and the log with its rows that counted
void writeLogDiagnosis(const LogDiagnosis& result, const FittedModel& given, const ActuatorModel& subject,
                       const PreparedLog& log, const LogSource& source, const RunDirectory& directory);
/// model.yaml, poses.csv and the tables of hypotheses and evidence.
void writePoseDiagnosis(const PoseDiagnosis& result, const RunDirectory& directory);

/// \name On motions: the same, and what each motion says
///@{
Json toJson(const MotionDiagnosis& result);
std::string terminalTable(const MotionDiagnosis& result);
/// baseline.yaml, model.yaml, residuals.csv and the tables of hypotheses and evidence; nothing where data are at fault.
void writeMotionDiagnosis(const MotionDiagnosis& result, const RunDirectory& directory);
/// arm_*.csv: the held-out motion of which the causes take most, as it was measured and as the models play it.
void writeMotionScene(const MotionDiagnosis& result, const RunDirectory& directory);
///@}

/// \name On a robot's log: the same, and what is left of each joint
///@{
Json toJson(const RobotDiagnosis& result);
std::string terminalTable(const RobotDiagnosis& result);
/// model.yaml where the robot's file can hold a cause, predictions.csv, the tables of hypotheses and evidence; nothing
/// where data are at fault.
void writeRobotDiagnosis(const RobotDiagnosis& result, const RobotLog& log, const RunDirectory& directory);
///@}

}  // namespace simgap
