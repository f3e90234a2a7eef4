// How a table of results is written (RFC 4180).
#include <array>
#include <cassert>
#include <charconv>

#include "csv_cells.h"
#include "simgap/core/csv.h"

namespace simgap {

CsvWriter::CsvWriter(const std::vector<std::string>& header) : columns_(header.size()) {
  for (const std::string& name : header) add(name);
  endRow();
}

CsvWriter& CsvWriter::add(double value) {
  std::array<char, 32> digits;
  const auto [stop, error] = std::to_chars(digits.data(), digits.data() + digits.size(), value);
  assert(error == std::errc());
  return append({digits.data(), static_cast<std::size_t>(stop - digits.data())});
}

CsvWriter& CsvWriter::add(std::string_view text) {
  // A row of one empty cell would be an empty line.
  const bool quote = text.find_first_of(",\"\n\r") != std::string_view::npos || (text.empty() && columns_ == 1);
  if (!quote) return append(isFormula(text) ? kNoFormula + std::string(text) : std::string(text));
  std::string cell = "\"";
  if (isFormula(text)) cell += kNoFormula;
  for (const char character : text) {
    if (character == '"') cell += '"';
    cell += character;
  }
  return append(cell + '"');
}

CsvWriter& CsvWriter::append(std::string_view cell) {
  if (cells_++ > 0) text_ += ',';
  text_ += cell;
  return *this;
}

CsvWriter& CsvWriter::endRow() {
  assert(cells_ == columns_);
  cells_ = 0;
  text_ += '\n';
  return *this;
}

}  // namespace simgap
