/// \file
/// Columns of a log's table to be written as they were read.
#pragma once

#include <string>
#include <vector>

#include "simgap/core/csv.h"

namespace simgap {

/// The table has the column and, where it is one of numbers, a number in every row.
bool isWhole(const CsvTable& table, const std::string& column);

class WholeColumns {
 public:
  /// \param names  columns that are whole
  WholeColumns(const CsvTable& table, const std::vector<std::string>& names);
  /// Adds their cells; the row is not ended.
  void addTo(CsvWriter& csv, std::size_t row) const;

 private:
  std::vector<std::vector<double>> numbers_;
  std::vector<std::vector<std::string>> texts_;  ///< shape (columns): empty where there are numbers
};

}  // namespace simgap
