/// \file
/// A log's table before its channels are read: rows that no channel can be taken from are left out and counted.
#pragma once

#include <cstddef>
#include <string>
#include <string_view>
#include <vector>

#include "simgap/core/csv.h"

namespace simgap {

/// Rows that were left out for one reason.
struct LeftOutRows {
  std::string channel;    ///< column of the log
  std::string sentence;   ///< "time_s repeats or goes back in 12 rows"
  std::size_t first_row;  ///< of the file, counted from 1 behind its header
  std::size_t last_row;
  std::size_t rows;
};

struct LogTable {
  CsvTable table;                     ///< without those rows
  std::vector<LeftOutRows> left_out;  ///< reasons that left out any

  /// One sentence about all of them, or none.
  std::vector<std::string> summary() const;
};

/// The log's columns as they were read, names and factors of --map done, as a file of its own; without columns that
/// lack numbers. \param without  a quantity that is left out, "motor_current"
std::string logCsv(const CsvTable& table, std::string_view without = {});

/// Rows of `log` that `other` has, too: readings of all channels that both have, the same in eight neighbouring rows
/// (noise does not repeat itself, whatever the clock says). Rows that are all alike, of a rest, say nothing.
std::size_t rowsInBoth(const CsvTable& log, const CsvTable& other);

/// True for a column that a log's reader takes as a channel: "motor_current_A".
bool isLogChannel(const std::string& column);

/// Leaves out rows without a number in one of the log's channels, and of the others as few as it takes for time to rise
/// within each session: stamps that repeat, or stand in the wrong order.
/// \param sessions  only these, all when empty.
/// \throws DataError: more than a tenth of the rows would have to go; a session that the log does not have.
LogTable readLogTable(CsvTable table, const std::vector<std::string>& sessions = {});

}  // namespace simgap
