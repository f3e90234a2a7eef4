/// \file
/// The tables of `design --separate`, from result.json.
#pragma once

#include <string>
#include <vector>

#include "simgap/report/table.h"

namespace simgap {

std::string separationAnswer(const Json& result);
std::vector<Table> separationTables(const Json& result);

}  // namespace simgap
