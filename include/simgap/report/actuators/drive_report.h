/// \file
/// What `fit-motor` and `fit-gearbox` show and write.
#pragma once

#include <optional>
#include <string>

#include "simgap/fit/actuators/fitted_drive.h"
#include "simgap/model/arm/arm.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap {

/// An arm that gets the fitted drive or cord.
struct ArmWithDrive {
  ArmModel arm;
  std::size_t muscle = 0;  ///< whose it is
};

struct DriveReport {
  std::string kind;  ///< "motor" or "gearbox"
  MotorLog log;
  std::string log_file, log_sha256;
  JudgedDriveFit fit;
  double ratio = 1.0;  ///< motor turns per turn of the output
  std::optional<ArmWithDrive> into;
};

/// The estimates as priors of the parameters of that muscle, YAML; what is fixed or unknown is left out.
std::string calibrationParameters(const std::string& muscle, const Uncertainty& uncertainty);

FitSummary summarise(const DriveReport& report);
/// model.yaml, response.csv and the tables; with an arm also arm.yaml and calibration_parameters.yaml, the priors from
/// which a calibration of it may start.
void writeDriveReport(const DriveReport& report, const RunDirectory& directory);

}  // namespace simgap
