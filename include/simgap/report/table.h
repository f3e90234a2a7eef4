/// \file
/// A table of a result. It is made once, from the result's JSON, so that the terminal and the page, which knows nothing
/// but the files of a run, show the same cells.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/run_directory.h"

namespace simgap {

struct Table {
  std::string caption;
  std::vector<std::string> header;
  std::vector<std::vector<std::string>> rows;  ///< cells are text; the first column names the row
  bool folded = false;                         ///< a page shows it only when opened
};

/// A number of JSON; NaN for null.
double numberOf(const Json& json);
/// A number of JSON in that format of fmt, "{:.5g}"; "-" for null.
std::string numberText(const Json& json, const char* format);

/// Text in columns: the first column left-aligned, the others right.
std::string alignedTable(const std::vector<std::vector<std::string>>& rows);
/// Header and rows, without the caption.
std::string alignedTable(const Table& table);

/// An angle in degrees with two decimals; "-" when unknown.
std::string degreesText(double rad);

}  // namespace simgap
