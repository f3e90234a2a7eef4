/// \file
/// What models predict for a log, beside what was measured, as a table.
#pragma once

#include <Eigen/Core>
#include <string>
#include <utility>
#include <vector>

#include "simgap/measure/logs/prepared_log.h"

namespace simgap {

/// time_s, measured, predictions by name, and whether a row counts. \param predictions  shape (rows) each
std::string predictionsCsv(const PreparedLog& log,
                           const std::vector<std::pair<std::string, const Eigen::ArrayXd*>>& predictions);

}  // namespace simgap
