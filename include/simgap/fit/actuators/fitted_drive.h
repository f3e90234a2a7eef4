/// \file
/// A motor or gearbox fitted to a log and judged on rows it did not see; a fitted one read back.
#pragma once

#include <optional>
#include <string>

#include "simgap/fit/actuators/drive_fit.h"
#include "simgap/fit/actuators/holdout.h"
#include "simgap/model/actuator/fitted_model.h"

namespace simgap {

/// Names of a drive's parameters, in the order of DriveFit::theta.
std::vector<std::string> driveParameterNames();

struct JudgedDriveFit {
  DriveFit fit;
  std::optional<DriveFit> trained;  ///< without the held-out rows, when `fit` has seen all
  std::string heldout;              ///< which rows, in words
  const DriveFit& judged() const { return trained ? *trained : fit; }
};

/// Keeps what `holdout` names from the fit; without one fits twice, to four fifths of the blocks and to all rows (once
/// when there are fewer than five blocks).
/// \param block_s  length of the blocks [s]; empty: as blockSeconds. \throws as fitDrive and fittedRows.
JudgedDriveFit fitAndJudge(const MotorLog& log, const DriveFitOptions& options, const Holdout& holdout,
                           const std::optional<double>& block_s);

/// A fitted motor's values, and a fitted gearbox's. \throws ConfigError: a model that lacks one of them.
Motor motorFrom(const FittedModel& model);
Gearbox gearboxFrom(const FittedModel& model);
/// How late the fit found the channels of its rig, in rows of this log; 0 where it says nothing.
DriveDelays delaysFrom(const FittedModel& model, const MotorLog& log);

/// Of a fitted motor's R, L, K_E, K_T, J_M, mu_M and tau_CM: as the model states it, else from the standard deviations;
/// empty when it states neither. The model has to be one that motorFrom takes.
Eigen::MatrixXd motorCovarianceFrom(const FittedModel& model);

}  // namespace simgap
