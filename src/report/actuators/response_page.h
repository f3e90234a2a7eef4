/// \file
/// Pages of what was simulated or predicted over time.
#pragma once

#include <string>

#include "simgap/report/html/page.h"
#include "simgap/report/html/result_files.h"

namespace simgap {

/// A chart per quantity Q that has columns Q<measured> and Q<computed> (with a unit behind): both over time (or over
/// the rows, without time_s).
void addResponses(const CsvTable& table, const std::string& measured, const std::string& computed, Page& page);

/// The page of fit-motor and fit-gearbox, from response.csv.
Page driveFitPage(const ResultFiles& files);

}  // namespace simgap
