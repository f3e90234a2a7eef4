/// \file
/// What `fit-friction` shows: the comparison of laws (003 table 2) and the paper's pictures on the user's own data.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/actuators/friction_comparison.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap {

/// A working point the drive has to reach (003 table 1).
struct Requirement {
  std::string name;
  double velocity;  ///< [rad/s] at the joint
  double torque;    ///< [N m]
};

struct FrictionReport {
  const FrictionData* data = nullptr;  ///< rows the laws were fitted to
  FrictionFitOptions options;
  FrictionComparison laws;
  std::vector<TransferRow> transfer;
  std::optional<double> ratio;  ///< motor per joint
  std::vector<Requirement> requirements;

  const FrictionFit& best() const { return laws.fits[laws.best]; }
};

FitSummary summarise(const FrictionReport& report);
/// model.yaml and the CSVs behind the tables and plots.
void writeFrictionReport(const FrictionReport& report, const std::string& log_sha256, const RunDirectory& directory);

/// The paper's requirements of daily living: shoulder 71 deg/s, elbow 91 deg/s, 20 N m.
std::vector<Requirement> paperRequirements();

/// \param texts  "NAME:DEG_PER_S:NM" each, or "paper" for those. \throws ConfigError
std::vector<Requirement> readRequirements(const std::vector<std::string>& texts);

}  // namespace simgap
