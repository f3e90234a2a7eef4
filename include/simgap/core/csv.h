/// \file
/// Strict reading and atomic writing of CSV (RFC 4180, header row, gzip when the name ends in .gz). Semicolons and tabs
/// separate, too; a separator may end each line.
#pragma once

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/units.h"

namespace simgap {

class CsvParser;

struct CsvOptions {
  bool skip_bad_rows = false;  ///< drop and count rows with a bad cell in a numeric column, or ragged rows
  std::map<std::string, std::string> rename;  ///< canonical name -> column of the file (`--map canonical=column`)
  std::map<std::string, double> scale = {};   ///< canonical name -> factor (`--map canonical=column*factor`)
  std::string missing_advice = {};            ///< ends the sentence of a missing column
};

/// A table held by columns. Numbers are parsed once, on loading; a column whose first cell that is not empty is no
/// number (NaN and inf count as bad numbers) is text. The file's text stays in memory: texts are cut out of it on
/// demand.
class CsvTable {
 public:
  /// \throws ConfigError when it cannot be read, DataError: empty, ragged, duplicate header, a `rename` that names no
  /// column; with its line.
  static CsvTable load(const std::filesystem::path& file, const CsvOptions& options = {});
  /// The same from the file's bytes, packed or not; `name` stands for the file in errors.
  static CsvTable parse(std::string text, const std::string& name, const CsvOptions& options = {});

  const std::string& name() const { return name_; }
  std::size_t rows() const { return rows_; }
  std::size_t skippedRows() const { return skipped_; }
  const std::vector<std::string>& columns() const { return headers_; }  ///< after renaming
  /// Line of the file, counted from 1, at which a data row begins.
  std::size_t lineOf(std::size_t row) const;

  bool has(std::string_view column) const;
  /// True for a column of numbers (its first cell that is not empty is one). \throws DataError when missing.
  bool isNumeric(std::string_view column) const;
  /// True when a column `stem` + "_" + (a unit that converts to `unit`) exists; with an empty unit: the column `stem`.
  bool hasQuantity(std::string_view stem, std::string_view unit) const;

  /// The same, for a column that need not be there. \throws DataError: a column of that stem whose unit is missing,
  /// unknown or of another kind (lists those that fit): it would be dropped without a word otherwise.
  bool offersQuantity(std::string_view stem, std::string_view unit) const;

  /// Rows, rising, in which a column of numbers has an empty cell, NaN, infinity or no number. \throws DataError when
  /// missing.
  std::vector<std::size_t> badRows(std::string_view column) const;
  /// The table of some of the rows. \param keep  shape (rows)
  CsvTable onlyRows(const std::vector<bool>& keep) const;

  /// The quantity in SI, shape (rows). Empty unit: a plain number column `stem`.
  /// \throws DataError: column missing (lists what is there, or names the wrong unit found), the quantity in two
  ///         units, or the first cell that is empty, NaN, infinite or no number, with its line.
  std::vector<double> quantity(std::string_view stem, std::string_view unit) const;
  /// The same without a copy when no other table shares the column, which is then gone from this one.
  std::vector<double> takeQuantity(std::string_view stem, std::string_view unit);

  /// A column as text, shape (rows); numbers as they stand in the file. Goes through the whole file.
  /// \throws DataError when missing.
  std::vector<std::string> text(std::string_view column) const;

  /// A DataError "FILE:LINE: sentence" about a row.
  [[noreturn]] void fail(std::size_t row, const std::string& sentence) const;

 private:
  friend CsvParser;
  QuantityMatch matched(std::string_view stem, std::string_view unit) const;
  std::vector<double> converted(std::vector<double> values, const QuantityMatch& match) const;
  [[noreturn]] void failMissing(std::string_view stem, std::string_view unit) const;
  [[noreturn]] void failCell(std::size_t row, std::size_t column) const;

  std::string name_;
  std::size_t rows_ = 0;
  std::size_t skipped_ = 0;
  std::vector<std::string> headers_;
  std::vector<std::shared_ptr<std::vector<double>>> numbers_;  ///< NaN: a bad cell; null: a column of text
  std::vector<std::uint32_t> lines_;                           ///< empty when row r stands on line r + 2
  std::shared_ptr<const std::string> text_;                    ///< the whole file
  char decimal_ = '.';                                         ///< or ','
  std::string missing_advice_;
};

/// Builds a CSV text: a header row, then rows of numbers (shortest form that reads back exactly) and texts (quoted when
/// they need it; an apostrophe before what a spreadsheet would calculate, which reading takes away again).
class CsvWriter {
 public:
  explicit CsvWriter(const std::vector<std::string>& header);
  CsvWriter& add(double value);
  CsvWriter& add(std::string_view text);
  CsvWriter& endRow();  ///< asserts that the row has as many cells as the header
  const std::string& text() const { return text_; }

 private:
  CsvWriter& append(std::string_view cell);

  std::size_t columns_;
  std::size_t cells_ = 0;
  std::string text_;
};

}  // namespace simgap
