/// \file
/// What `fit-friction` shows: the comparison of laws (003 table 2) and the paper's pictures on the user's own data.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/actuators/friction_maps.h"
#include "simgap/fit/actuators/requirements.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap {

struct FrictionReport {
  const FrictionData* data = nullptr;  ///< rows the laws were fitted to
  FrictionFitOptions options;
  FrictionComparison laws;
  std::vector<TransferRow> transfer;
  std::optional<double> ratio;  ///< motor per joint
  std::vector<Requirement> requirements;
  std::vector<double> position;  ///< [rad] of the motor in every row of the log; empty when it has none

  const FrictionFit& best() const { return laws.fits[laws.best]; }
  FittedRows rows() const { return {*data, options, laws}; }
};

FitSummary summarise(const FrictionReport& report);
/// model.yaml and the CSVs behind the tables and plots.
void writeFrictionReport(const FrictionReport& report, const std::string& log_sha256, const RunDirectory& directory);

}  // namespace simgap
