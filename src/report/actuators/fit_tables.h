/// \file
/// The tables of the fit-* commands, from result.json.
#pragma once

#include <string>

#include "simgap/report/table.h"

namespace simgap {

/// Models on the same rows, the first the one that others are compared with; the lowest BIC is marked.
Table fitComparison(const Json& result);
/// Estimates with standard deviation and interval.
Table fitParameters(const Json& result);

/// How the search went; empty without one over several starts.
std::string searchText(const Json& starts);
/// "RMS 0.01 A (300 rows)": the error on another log, one entry of `transfer`.
std::string transferText(const Json& transfer, const std::string& unit);

}  // namespace simgap
