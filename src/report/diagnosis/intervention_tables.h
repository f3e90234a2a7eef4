/// \file
/// The tables of `intervene`, from result.json.
#pragma once

#include <string>
#include <vector>

#include "simgap/report/table.h"

namespace simgap {

std::string interventionAnswer(const Json& result);
std::vector<Table> interventionTables(const Json& result);

}  // namespace simgap
