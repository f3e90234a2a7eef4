/// \file
/// What `fit-spring` shows and writes: the spring in both directions and as a cord, on the user's data (000 IV).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/actuators/spring_fit.h"
#include "simgap/report/actuators/drive_report.h"

namespace simgap {

struct SpringReport {
  PreparedLog log;
  bool own_length = false;  ///< the deflection is the spring's own length: the cord's rest length is known, too
  std::string log_sha256;
  SpringComparison comparison;
  std::vector<TransferRow> transfer;
  std::optional<ArmWithDrive> into;  ///< the arm whose cord it is
};

FitSummary summarise(const SpringReport& report);
/// model.yaml, the tables, and the CSVs behind the plots of force over deflection and of the error; with an arm also
/// arm.yaml and calibration_parameters.yaml.
void writeSpringReport(const SpringReport& report, const RunDirectory& directory);

}  // namespace simgap
