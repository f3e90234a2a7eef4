#include "simgap/report/table.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>
#include <sstream>

#include "simgap/core/csv.h"
#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr std::size_t kGap = 2;  ///< between columns

/// Per column the largest `width` of its cells.
std::vector<std::size_t> columnWidths(const std::vector<std::vector<std::string>>& rows,
                                      std::size_t (*width)(std::string_view)) {
  std::vector<std::size_t> widths(1);
  for (const auto& row : rows) {
    widths.resize(std::max(widths.size(), row.size()));
    for (std::size_t c = 0; c < row.size(); ++c) widths[c] = std::max(widths[c], width(row[c]));
  }
  return widths;
}

std::size_t widestWord(std::string_view cell) {
  const std::vector<std::string> words = wordLines(cell, 0);
  std::size_t widest = 0;
  for (const std::string& word : words) widest = std::max(widest, textWidth(word));
  return widest;
}

/// Takes from the widest column, as long as its words allow it, until all fit into a line.
void narrow(std::vector<std::size_t>& widths, const std::vector<std::size_t>& least) {
  std::size_t total = kGap * (widths.size() - 1);
  for (const std::size_t width : widths) total += width;
  for (; total > kTextWidth; --total) {
    std::size_t widest = widths.size();
    for (std::size_t c = 0; c < widths.size(); ++c) {
      if (widths[c] > least[c] && (widest == widths.size() || widths[c] > widths[widest])) widest = c;
    }
    if (widest == widths.size()) return;
    --widths[widest];
  }
}

/// The first column, to the left, and columns from `begin` to `end`, to the right; cells take as many lines as they
/// need.
std::string tableRow(const std::vector<std::string>& row, const std::vector<std::size_t>& widths, std::size_t begin,
                     std::size_t end) {
  std::vector<std::vector<std::string>> cells(row.size());
  std::size_t lines = 1;
  for (std::size_t c = 0; c < row.size(); ++c) {
    const bool fits = textWidth(row[c]) <= widths[c];
    cells[c] = fits ? std::vector{row[c]} : wordLines(row[c], widths[c]);
    if (c == 0 || (c >= begin && c < end)) lines = std::max(lines, cells[c].size());
  }
  const auto cell = [&](std::size_t c, std::size_t l) { return l < cells[c].size() ? cells[c][l] : std::string(); };
  const auto blanks = [&](std::size_t c, const std::string& part) {
    return std::string(widths[c] - std::min(widths[c], textWidth(part)), ' ');
  };
  std::string text;
  for (std::size_t l = 0; l < lines; ++l) {
    std::string line = cell(0, l) + blanks(0, cell(0, l));
    for (std::size_t c = begin; c < std::min(end, row.size()); ++c) {
      line += std::string(kGap, ' ') + blanks(c, cell(c, l)) + cell(c, l);
    }
    text += line.substr(0, line.find_last_not_of(' ') + 1) + "\n";
  }
  return text;
}

}  // namespace

double numberOf(const Json& json) { return json.is_number() ? json.get<double>() : std::nan(""); }

std::string numberText(const Json& json, const char* format) {
  const double number = numberOf(json);
  if (!std::isfinite(number)) return "-";
  std::string text = fmt::format(fmt::runtime(format), number);
  const std::size_t behind = text.find_first_not_of("-0.");
  const bool rounds_to_none = text.starts_with("-0") && (behind == std::string::npos || text[behind] == ' ');
  return rounds_to_none ? text.substr(1) : text;  // -0.3 as a whole number
}

std::string alignedTable(const std::vector<std::vector<std::string>>& rows) {
  std::vector<std::size_t> widths = columnWidths(rows, textWidth);
  narrow(widths, columnWidths(rows, widestWord));
  std::string text;
  for (std::size_t begin = 1, end = 0; end < widths.size(); begin = end) {
    std::size_t width = widths[0];
    for (end = begin; end < widths.size() && (end == begin || width + kGap + widths[end] <= kTextWidth); ++end) {
      width += kGap + widths[end];
    }
    if (!text.empty()) text += "\n";
    for (const auto& row : rows) text += tableRow(row, widths, begin, end);
  }
  return text;
}

std::string capitalised(std::string words) {
  if (!words.empty() && words[0] >= 'a' && words[0] <= 'z') words[0] = static_cast<char>(words[0] - 'a' + 'A');
  return words;
}

std::string unitTitle(const std::string& unit) {
  static const std::map<std::string, std::string> kTokens = {{"Nm", "N m"}, {"Nms", "N m s"}, {"Ns", "N s"},
                                                             {"Vs", "V s"}, {"ohm", "Ω"},     {"degC", "°C"}};
  static const std::map<std::string, std::string> kProducts = {
      {"kg_m", "kg m"}, {"kg_m2", "kg m²"}, {"V_s_rad", "V s/rad"}, {"A_s_rad", "A s/rad"}};
  if (const auto product = kProducts.find(unit); product != kProducts.end()) return product->second;
  std::string title, token;
  std::istringstream tokens(unit);
  for (; std::getline(tokens, token, '_'); title += token) {
    const bool squared = token.size() > 1 && token.back() == '2', cubed = token.size() > 1 && token.back() == '3';
    if (squared || cubed) token.pop_back();
    if (const auto known = kTokens.find(token); known != kTokens.end()) token = known->second;
    token += squared ? "²" : cubed ? "³" : "";
    if (!title.empty()) title += '/';
  }
  return title;
}

std::string probabilityText(const Json& p) { return numberOf(p) < 1e-4 ? "< 0.0001" : numberText(p, "{:.2g}"); }

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

std::string answerText(const std::string& answer, const std::vector<Table>& tables) {
  std::string text = answer + "\n\n";
  for (const Table& table : tables) text += table.caption + "\n" + alignedTable(table) + "\n";
  return text;
}

}  // namespace simgap
