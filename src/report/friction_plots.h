/// \file
/// The pictures of a friction fit: 003 figures 10, 12-14 and 16 on the user's data.
#pragma once

#include "simgap/report/friction_report.h"

namespace simgap {

/// A row that the plot over time shows.
struct TimeSample {
  std::size_t index;
  double measured;
  std::vector<double> predicted;  ///< shape (fits)
};
/// At most some 1,500 rows in order: a stretch without gaps around the middle of the log.
std::vector<TimeSample> timeSamples(const FrictionReport& report);

/// Per cell of torque x velocity: rows, and mean absolute error of every law.
std::string mapsCsv(const FrictionReport& report);

/// Whether the data reach each requirement.
std::vector<std::string> requirementSentences(const FrictionReport& report);

void addFrictionCharts(const FrictionReport& report, Page& page);

}  // namespace simgap
