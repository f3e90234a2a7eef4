/// \file
/// The tables of the fit-* commands, from result.json.
#pragma once

#include <string>

#include "simgap/report/table.h"

namespace simgap {

/// What was fitted, and how well.
std::string fitAnswer(const Json& result);
/// Models on the same rows, the first the one that others are compared with; what was chosen is marked.
Table fitComparison(const Json& result);
/// Estimates with standard deviation and interval.
Table fitParameters(const Json& result);

/// Rows, the search, other logs, and what else the fit has to say.
Table fitFacts(const Json& result);

/// "velocity_rad_s" -> "velocity [rad/s]"
std::string axisTitle(const std::string& column);

}  // namespace simgap
