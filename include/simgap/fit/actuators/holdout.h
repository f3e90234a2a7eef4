/// \file
/// Rows that are kept from a fit to judge it by: whole blocks, because neighbouring rows of a log say the same.
#pragma once

#include <optional>
#include <span>
#include <string>
#include <vector>

#include "simgap/core/blocks.h"
#include "simgap/core/csv.h"

namespace simgap {

/// What `--holdout` names, of a log's table: rows by a column's values, or a fraction of the blocks.
struct Holdout {
  std::optional<double> fraction;
  std::vector<bool> rows;  ///< shape (rows): named by values
  std::string words;       ///< for reports

  bool any() const { return fraction.has_value() || !rows.empty(); }
};

/// \param text  "0.2", or "session=5,6"; empty: nothing is held out.
/// \throws ConfigError for a text that is neither, DataError for values that no row has.
Holdout readHoldout(const std::string& text, const CsvTable& table);

/// False for the rows that are held out, shape (rows of `blocks`). A fraction is spread evenly over the blocks.
/// \param row  row of the log of each of them.
/// \throws DataError when none of them or all are held out.
std::vector<bool> fittedRows(const Holdout& holdout, std::span<const Block> blocks, std::span<const std::size_t> row);
/// The same where the blocks are of the whole log.
std::vector<bool> fittedRows(const Holdout& holdout, std::span<const Block> blocks);

/// The rows that candidates are fitted to, and those that judge them.
struct JudgedRows {
  std::vector<bool> fitted;  ///< shape (rows)
  std::string words;         ///< which rows judge
  bool then_all = false;     ///< the final fit has all rows
};
/// Without a holdout a fifth of five or more blocks judges. \throws DataError as fittedRows.
JudgedRows judgedRows(const Holdout& holdout, std::span<const Block> blocks);

/// Length of the blocks for a log of that duration [s]: what was asked for, else 20 s, in short logs a tenth of them.
double blockSeconds(const std::optional<double>& asked, double duration);

}  // namespace simgap
