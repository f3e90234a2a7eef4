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
/// A number of JSON in that format of fmt, "{:.5g}"; "-" for null and what is not finite.
std::string numberText(const Json& json, const char* format);

/// Text in columns, the first left-aligned, the others right, at most kTextWidth wide: cells break between words where
/// they have to, and columns that do not fit even so follow below, beside the first column again.
std::string alignedTable(const std::vector<std::vector<std::string>>& rows);
/// Header and rows, without the caption.
std::string alignedTable(const Table& table);
/// What a command answered, and its tables below, each with its caption.
std::string answerText(const std::string& answer, const std::vector<Table>& tables);

/// A unit as people write it: "rad_s" is "rad/s", "1_rad" is "1/rad", "A2" is "A²".
std::string unitTitle(const std::string& unit);

/// Begun with a capital letter.
std::string capitalised(std::string words);

/// A probability: what is less than 0.0001 is not told more exactly.
std::string probabilityText(const Json& p);

/// A value as a file holds it: words as they are, a number in the shortest form that reads back, nothing for null.
std::string cellText(const Json& value);
/// A row per object of a list, a column per key.
Table recordTable(std::string caption, const Json& records, const std::vector<std::string>& keys);
/// Header and rows as CSV.
std::string csvText(const Table& table);

/// Degrees of JSON with two decimals; "-" when unknown.
inline std::string degreesCell(const Json& degrees) { return numberText(degrees, "{:.2f}"); }

}  // namespace simgap
