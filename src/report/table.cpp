#include "simgap/report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/rotation.h"

namespace simgap {

double numberOf(const Json& json) { return json.is_number() ? json.get<double>() : std::nan(""); }

std::string numberText(const Json& json, const char* format) {
  return json.is_number() ? fmt::format(fmt::runtime(format), json.get<double>()) : "-";
}

std::string degreesText(double rad) { return std::isfinite(rad) ? fmt::format("{:.2f}", toDegrees(rad)) : "-"; }

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

std::string alignedTable(const Table& table) {
  std::vector<std::vector<std::string>> rows{table.header};
  rows.insert(rows.end(), table.rows.begin(), table.rows.end());
  return alignedTable(rows);
}

}  // namespace simgap
