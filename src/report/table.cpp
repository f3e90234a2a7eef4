#include "simgap/report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"

namespace simgap {

double numberOf(const Json& json) { return json.is_number() ? json.get<double>() : std::nan(""); }

std::string numberText(const Json& json, const char* format) {
  const double number = numberOf(json);
  return std::isfinite(number) ? fmt::format(fmt::runtime(format), number) : "-";
}

std::string alignedTable(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths;
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], row[c].size());
  }
  std::string text;
  for (const auto& row : rows) {
    std::string line = fmt::format("{:<{}}", row.front(), widths[0]);
    for (std::size_t c = 1; c < row.size(); ++c) line += fmt::format("  {:>{}}", row[c], widths[c]);
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

std::string cellText(const Json& value) {
  if (value.is_null()) return {};
  if (value.is_number_float()) return fmt::format("{}", value.get<double>());
  return value.is_string() ? value.get<std::string>() : value.dump();
}

Table recordTable(std::string caption, const Json& records, const std::vector<std::string>& keys) {
  Table table{std::move(caption), keys, {}};
  for (const Json& record : records) {
    table.rows.emplace_back();
    for (const std::string& key : keys) table.rows.back().push_back(cellText(record.value(key, Json(nullptr))));
  }
  return table;
}

std::string csvText(const Table& table) {
  CsvWriter csv(table.header);
  for (const auto& row : table.rows) {
    for (const std::string& cell : row) csv.add(cell);
    csv.endRow();
  }
  return csv.text();
}

std::string alignedTable(const Table& table) {
  std::vector<std::vector<std::string>> rows{table.header};
  rows.insert(rows.end(), table.rows.begin(), table.rows.end());
  return alignedTable(rows);
}

}  // namespace simgap
