/// \file
/// Results as people read them in a terminal.
#pragma once

#include <string>
#include <vector>

namespace simgap {

/// Text in columns: the first column left-aligned, the others right.
std::string alignedTable(const std::vector<std::vector<std::string>>& rows);

/// An angle in degrees with two decimals; "-" when unknown.
std::string degreesText(double rad);

}  // namespace simgap
