/// \file
/// What `fit-friction` shows: the comparison of laws (003 table 2) and the paper's pictures on the user's own data.
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/actuators/friction_fit.h"
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
  std::vector<FrictionFit> fits;  ///< at least one
  std::size_t best = 0;
  std::string heldout;
  std::vector<std::string> left_out;
  std::vector<TransferRow> transfer;
  std::optional<double> ratio;  ///< motor per joint
  std::vector<Requirement> requirements;
};

FitSummary summarise(const FrictionReport& report);
/// model.yaml and the CSVs behind the tables and plots.
void writeFrictionReport(const FrictionReport& report, const std::string& log_sha256, const RunDirectory& directory);

/// The paper's requirements of daily living: shoulder 71 deg/s, elbow 91 deg/s, 20 N m.
std::vector<Requirement> paperRequirements();

}  // namespace simgap
