/// \file
/// What `fit-pam` shows and writes: the muscle with and without its tendon's spring, on the user's data (002).
#pragma once

#include <optional>
#include <string>
#include <vector>

#include "simgap/fit/actuators/pam_comparison.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap {

struct PamReport {
  PamLog log;
  std::string log_sha256;
  std::optional<PamFit> maker;  ///< the fit to the maker's curves, where a, b, c come from
  std::string maker_file;
  PamComparison comparison;
  std::vector<TransferRow> transfer;
};

FitSummary summarise(const PamReport& report);
/// model.yaml, the tables, and the CSVs behind the plots of force over contraction and of the error.
void writePamReport(const PamReport& report, const RunDirectory& directory);

}  // namespace simgap
