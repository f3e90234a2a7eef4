/// \file
/// The tables of `intervene`, from result.json.
#pragma once

#include <string>
#include <vector>

#include "simgap/report/table.h"

namespace simgap {

/// The change that would tell most, or that none would. \param log_odds  expected, the smallest of any rival
std::string foreseenSentence(const std::string& named, const std::string& change, double log_odds);
std::string interventionAnswer(const Json& result);
std::vector<Table> interventionTables(const Json& result);

}  // namespace simgap
