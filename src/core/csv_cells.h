/// \file
/// The text of a CSV file and its cells, one after the other (RFC 4180; a line may end in LF or CRLF; semicolons and
/// tabs separate, too).
#pragma once

#include <array>
#include <cstddef>
#include <cstdint>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/run_directory.h"

namespace simgap {

/// The text of a file's bytes: whatever begins as gzip does is unpacked.
/// \throws DataError: not gzip although the name ends in .gz, truncated or damaged, or more than `largest` bytes
/// unpacked.
std::string unpackCsv(std::string packed, const std::string& file, std::size_t largest = kLargestFile);

/// A text that a spreadsheet would calculate, behind apostrophes or not: a name =cmd|… in a file somebody sent would
/// run there. Numbers are none.
bool isFormula(std::string_view text);
/// Stands before such a text in a file; spreadsheets do not show it.
inline constexpr char kNoFormula = '\'';

/// A DataError "FILE:LINE: sentence".
[[noreturn]] void failInCsv(const std::string& file, std::uint32_t line, const std::string& sentence);

struct CsvCell {
  std::string_view raw;  ///< without its outer quotes
  bool escaped = false;  ///< holds doubled quotes
  bool last = false;     ///< ends its row

  std::string text() const;  ///< without the apostrophe before a formula
  /// NaN when it reads as a number but is not finite; empty when it is no number. \param decimal  '.' or ','
  std::optional<double> number(char decimal) const;
};

/// A cursor over the cells. Empty lines at the end do not count. Cells are separated by what the header has most of:
/// commas, semicolons or tabs. Where it is no comma, numbers may have decimal commas: then all of them have.
class CsvCells {
 public:
  /// Both must outlive the cursor; `file` stands in errors.
  CsvCells(std::string_view text, const std::string& file);

  bool atEnd() const { return at_ == end_ && !cell_due_; }
  std::uint32_t line() const { return line_; }  ///< of the next cell
  char decimal() const { return decimal_; }     ///< '.' or ','

  /// \throws DataError: quotes or carriage returns where none may be.
  CsvCell next();
  /// Reads the next cell when it is a finite number without quotes; stays before it otherwise.
  bool nextNumber(double& value, bool& last);
  std::vector<std::string> nextRow();
  void skipRow();

  /// An upper bound of the rows left, when each has so many columns.
  std::size_t mostRowsLeft(std::size_t columns) const;

 private:
  CsvCell quotedCell();
  /// True at the end of a cell. Sets `last`, and the step past the separator.
  bool separatorAt(const char* at, bool& last, std::size_t& length) const;
  void step(const char* separator, std::size_t length, bool last);

  const std::string& file_;
  const char* at_;
  const char* end_;
  std::array<bool, 256> stops_{};  ///< characters at which the scan of an unquoted cell stops
  char separator_ = ',';
  char decimal_ = '.';
  std::uint32_t line_ = 1;
  bool cell_due_ = false;  ///< the text ended behind a separator: one empty cell is left
};

}  // namespace simgap
