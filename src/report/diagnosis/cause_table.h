/// \file
/// The tables of a diagnosis, from result.json.
#pragma once

#include <string>

#include "simgap/report/table.h"

namespace simgap {

/// "muscle-wrap of biceps"
std::string causeName(const Json& cause);

/// In the order they were found: gain on data never used, adjusted p, parameters with half their interval.
Table causeTable(const Json& result);

/// Of a self-test: hidden effects by row, answers by column.
Table confusionTable(const Json& result);

}  // namespace simgap
