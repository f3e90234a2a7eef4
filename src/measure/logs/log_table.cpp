#include "simgap/measure/logs/log_table.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <functional>
#include <set>
#include <span>
#include <unordered_set>

#include "simgap/core/blocks.h"
#include "simgap/core/error.h"
#include "simgap/core/text.h"
#include "simgap/measure/logs/actuator_log.h"
#include "whole_columns.h"

namespace simgap {
namespace {

constexpr double kMostLeftOut = 0.1;  // of the rows: what lacks more is another log than it seems

bool tooMany(std::size_t rows, const CsvTable& table) {
  return static_cast<double>(rows) > kMostLeftOut * static_cast<double>(table.rows());
}

double percent(std::size_t rows, const CsvTable& table) {
  return 100.0 * static_cast<double>(rows) / static_cast<double>(table.rows());
}

LeftOutRows leftOut(const CsvTable& table, const std::string& channel, const std::string& what,
                    const std::vector<std::size_t>& rows) {
  // The header stands on line 1.
  return {channel, fmt::format("{} {} in {} rows", channel, what, rows.size()), table.lineOf(rows.front()) - 1,
          table.lineOf(rows.back()) - 1, rows.size()};
}

/// A temperature is often logged more slowly than the rest: then it is not looked at, and the rows stay.
bool mayBeSparse(const std::string& column) { return splitUnit(column).stem == "temperature"; }

void leaveOutEmptyCells(LogTable& log) {
  const CsvTable& table = log.table;
  std::vector<bool> keep(table.rows(), true);
  for (const std::string& column : table.columns()) {
    if (!isLogChannel(column)) continue;
    const std::vector<std::size_t> bad = table.badRows(column);
    if (bad.empty() || (tooMany(bad.size(), table) && mayBeSparse(column))) continue;
    if (tooMany(bad.size(), table)) {
      const std::string found = table.text(column)[bad.front()];
      table.fail(bad.front(),
                 fmt::format("found {}, and {} of {} rows ({:.1f} %) have no number in {}, expected at most "
                             "{:.0f} %",
                             found.empty() ? "an empty cell" : fmt::format("'{}'", found), bad.size(), table.rows(),
                             percent(bad.size(), table), column, 100.0 * kMostLeftOut));
    }
    log.left_out.push_back(leftOut(table, column, "has no number", bad));
    for (const std::size_t row : bad) keep[row] = false;
  }
  if (!log.left_out.empty()) log.table = table.onlyRows(keep);
}

/// Rows of a block that are not in its longest rising subsequence (Schensted 1961), the fewest that can go.
std::vector<std::size_t> rowsOutOfOrder(const std::vector<double>& time, const Block& rows) {
  std::vector<std::size_t> tails;                   // row that ends the best subsequence of each length
  std::vector<std::size_t> before(rows.size(), 0);  // in the subsequence that ends with a row
  for (std::size_t i = rows.begin; i < rows.end; ++i) {
    const auto place = std::ranges::lower_bound(tails, time[i], {}, [&](std::size_t row) { return time[row]; });
    if (place != tails.begin()) before[i - rows.begin] = *std::prev(place);
    if (place == tails.end()) {
      tails.push_back(i);
    } else {
      *place = i;
    }
  }
  std::vector<bool> kept(rows.size(), false);
  std::size_t row = tails.back();
  for (std::size_t length = tails.size(); length > 0; --length) {
    kept[row - rows.begin] = true;
    row = before[row - rows.begin];
  }
  std::vector<std::size_t> others;
  for (std::size_t i = rows.begin; i < rows.end; ++i) {
    if (!kept[i - rows.begin]) others.push_back(i);
  }
  return others;
}

void leaveOutBadStamps(LogTable& log) {
  const CsvTable& table = log.table;
  if (table.rows() == 0 || !table.offersQuantity("time", "s")) return;
  const std::vector<double> time = table.quantity("time", "s");
  std::vector<std::string> names;
  CsvTable copy = table;
  const std::vector<int> session = readSessions(copy, names);
  std::vector<std::size_t> bad;
  for (const Block& rows : splitRows(session, table.rows())) {
    const bool rises = std::is_sorted(time.begin() + static_cast<std::ptrdiff_t>(rows.begin),
                                      time.begin() + static_cast<std::ptrdiff_t>(rows.end), std::less_equal<>());
    if (!rises) std::ranges::copy(rowsOutOfOrder(time, rows), std::back_inserter(bad));
  }
  if (bad.empty()) return;
  if (tooMany(bad.size(), table)) {
    std::size_t i = 1;
    while (session[i] != session[i - 1] || time[i] > time[i - 1]) ++i;
    table.fail(
        i,
        fmt::format("time goes from {} s to {} s, and {} of {} rows ({:.1f} %) repeat or go back, expected at "
                    "most {:.0f} %: time has to rise within a session (a column `session` separates runs that "
                    "begin anew)",
                    time[i - 1], time[i], bad.size(), table.rows(), percent(bad.size(), table), 100.0 * kMostLeftOut));
  }
  std::vector<bool> keep(table.rows(), true);
  for (const std::size_t row : bad) keep[row] = false;
  log.left_out.push_back(leftOut(table, "time", "repeats or goes back", bad));
  log.table = table.onlyRows(keep);
}

CsvTable keepSessions(CsvTable table, const std::vector<std::string>& chosen) {
  if (chosen.empty()) return table;
  CsvTable copy = table;
  std::vector<std::string> names;
  const std::vector<int> session = readSessions(copy, names);
  std::vector<bool> wanted(names.size(), false);
  for (const std::string& name : chosen) {
    const auto found = std::ranges::find(names, name);
    if (found == names.end()) {
      throw DataError(fmt::format("{}: found no session {}, expected one of {}", table.name(), name, listed(names)));
    }
    wanted[found - names.begin()] = true;
  }
  std::vector<bool> keep(table.rows());
  for (std::size_t i = 0; i < keep.size(); ++i) keep[i] = wanted[session[i]];
  return table.onlyRows(keep);
}

constexpr std::size_t kRun = 8;  // neighbouring rows that are compared at once

/// Readings of two logs, one behind the other, shape (channels) of (rows).
using Readings = std::vector<std::vector<double>>;

/// A run of rows, by the first of them, for a set of runs that hold different readings.
struct RunHash {
  const Readings* readings;
  std::size_t operator()(std::size_t first) const {
    std::size_t hash = 0;
    for (const std::vector<double>& channel : *readings) {
      for (std::size_t k = 0; k < kRun; ++k) hash = 1099511628211U * (hash ^ std::hash<double>()(channel[first + k]));
    }
    return hash;
  }
};

struct SameRun {
  const Readings* readings;
  bool operator()(std::size_t one, std::size_t other) const {
    return std::ranges::all_of(*readings, [&](const std::vector<double>& channel) {
      const auto rows = [&](std::size_t first) { return std::span(channel).subspan(first, kRun); };
      return std::ranges::equal(rows(one), rows(other));
    });
  }
};

bool standsStill(const Readings& readings, std::size_t first) {
  return std::ranges::all_of(readings, [&](const std::vector<double>& channel) {
    const std::span rows = std::span(channel).subspan(first, kRun);
    return std::ranges::all_of(rows, [&](double reading) { return reading == rows.front(); });
  });
}

}  // namespace

std::vector<std::string> LogTable::summary() const {
  if (left_out.empty()) return {};
  std::vector<std::string> reasons;
  for (const LeftOutRows& rows : left_out) reasons.push_back(rows.sentence);
  return {fmt::format("{}: rows were left out: {}", table.name(), fmt::join(reasons, "; "))};
}

std::size_t rowsInBoth(const CsvTable& log, const CsvTable& other) {
  const auto notShared = [&](const std::string& name) {
    return name == "session" || splitUnit(name).stem == "time" || !isWhole(log, name) || !other.has(name) ||
           !isWhole(other, name) || !log.isNumeric(name) || !other.isNumeric(name);
  };
  std::vector<std::string> names = log.columns();
  std::erase_if(names, notShared);
  if (names.empty()) return 0;
  Readings readings;
  for (const std::string& name : names) {
    const std::vector<double> own = log.quantity(name, "");
    std::vector<double>& both = readings.emplace_back(other.quantity(name, ""));
    both.insert(both.end(), own.begin(), own.end());
  }
  std::unordered_set<std::size_t, RunHash, SameRun> runs(0, RunHash{&readings}, SameRun{&readings});
  for (std::size_t i = 0; i + kRun <= other.rows(); ++i) {
    if (!standsStill(readings, i)) runs.insert(i);
  }
  std::vector<bool> seen(log.rows(), false);
  for (std::size_t i = 0; i + kRun <= seen.size(); ++i) {
    if (!runs.contains(other.rows() + i)) continue;
    std::fill_n(seen.begin() + static_cast<std::ptrdiff_t>(i), kRun, true);
  }
  return static_cast<std::size_t>(std::ranges::count(seen, true));
}

bool isLogChannel(const std::string& column) {
  static const std::set<std::string> kStems = {
      "time",           "motor_current",  "motor_voltage",  "motor_torque",   "motor_force", "motor_velocity",
      "velocity",       "joint_velocity", "motor_position", "joint_position", "position",    "external_torque",
      "external_force", "current",        "voltage",        "load_torque",    "pressure",    "force",
      "temperature",    "deflection",     "length",         "torque"};
  return column == "session" || column == "contraction" || kStems.contains(splitUnit(column).stem);
}

LogTable readLogTable(CsvTable table, const std::vector<std::string>& sessions) {
  LogTable log{keepSessions(std::move(table), sessions), {}};
  leaveOutEmptyCells(log);
  leaveOutBadStamps(log);
  return log;
}

std::string logCsv(const CsvTable& table, std::string_view without) {
  std::vector<std::string> names = table.columns();
  std::erase_if(names, [&](const std::string& name) {
    return !isWhole(table, name) || (!without.empty() && splitUnit(name).stem == without);
  });
  const WholeColumns columns(table, names);
  CsvWriter csv(names);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    columns.addTo(csv, row);
    csv.endRow();
  }
  return csv.text();
}

}  // namespace simgap
