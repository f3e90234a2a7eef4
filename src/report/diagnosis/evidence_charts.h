/// \file
/// What the model missed, on average, against every channel that was logged: before the causes and with them.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/csv.h"
#include "simgap/report/html/result_page.h"

namespace simgap {

/// Mean residuals, ranked by what the causes took away of them.
struct EvidenceTable {
  CsvTable table;                     ///< evidence.csv
  std::vector<std::string> channels;  ///< first those against which most was taken away; empty: there is none
};
EvidenceTable evidenceOf(const ResultFiles& files);

/// Mean residual against one of the channels, before and after the causes. \param unit  of the residual
Chart evidenceChart(const CsvTable& table, const std::string& against, const std::string& unit);

}  // namespace simgap
