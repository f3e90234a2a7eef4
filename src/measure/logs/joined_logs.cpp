#include "simgap/measure/logs/joined_logs.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <filesystem>
#include <utility>

#include "simgap/core/error.h"
#include "whole_columns.h"

namespace simgap {
namespace {

constexpr std::string_view kSession = "session";

/// A log without the column, or where it has gaps; the end where there is none.
auto lacking(std::span<const LogTable> logs, const std::string& column) {
  return std::ranges::find_if(logs, [&](const LogTable& log) { return !isWhole(log.table, column); });
}

/// A temperature that one log has and another has not would be lost without a word.
void requireSameChannels(std::span<const LogTable> logs) {
  for (const LogTable& log : logs) {
    for (const std::string& column : log.table.columns()) {
      if (column == kSession || !isLogChannel(column)) continue;
      const auto without = lacking(logs, column);
      if (without == logs.end()) continue;
      throw DataError(fmt::format("{}: found no whole column {}, which {} has; expected the same channels in every log",
                                  without->table.name(), column, log.table.name()));
    }
  }
}

/// The columns that every log has, without gaps where they are numbers; `session` is written anew.
std::vector<std::string> sharedColumns(std::span<const LogTable> logs) {
  std::vector<std::string> shared;
  for (const std::string& column : logs[0].table.columns()) {
    if (column != kSession && lacking(logs, column) == logs.end()) shared.push_back(column);
  }
  return shared;
}

/// A log's own sessions behind the name of its file.
std::vector<std::string> sessionsOf(const CsvTable& table, std::size_t number) {
  std::filesystem::path name = std::filesystem::path(table.name()).filename();
  if (name.extension() == ".gz") name = name.stem();
  const std::string file = fmt::format("{}-{}", number + 1, name.stem().string());
  if (!table.has(kSession)) return std::vector(table.rows(), file);
  std::vector<std::string> sessions = table.text(kSession);
  for (std::string& session : sessions) session = fmt::format("{}-{}", file, session);
  return sessions;
}

void appendRows(const CsvTable& table, std::size_t number, const std::vector<std::string>& names, CsvWriter& csv) {
  const WholeColumns columns(table, names);
  const std::vector<std::string> sessions = sessionsOf(table, number);
  for (std::size_t row = 0; row < table.rows(); ++row) {
    columns.addTo(csv, row);
    csv.add(sessions[row]).endRow();
  }
}

}  // namespace

LogTable joinedLogs(std::vector<LogTable> logs) {
  if (logs.size() == 1) return std::move(logs[0]);
  requireSameChannels(logs);
  const std::vector<std::string> columns = sharedColumns(logs);
  std::vector<std::string> header = columns, names;
  header.emplace_back(kSession);
  CsvWriter csv(header);
  std::vector<LeftOutRows> left_out;
  for (std::size_t i = 0; i < logs.size(); ++i) {
    appendRows(logs[i].table, i, columns, csv);
    names.push_back(logs[i].table.name());
    for (LeftOutRows& rows : logs[i].left_out) {
      rows.sentence = fmt::format("{}: {}", names.back(), rows.sentence);
      left_out.push_back(std::move(rows));
    }
  }
  // Two packed files are no packed text: the name may not end as theirs.
  return {CsvTable::parse(csv.text(), fmt::format("{} (together)", fmt::join(names, " and "))), std::move(left_out)};
}

}  // namespace simgap
