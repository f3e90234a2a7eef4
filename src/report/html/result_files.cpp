#include "simgap/report/html/result_files.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <utility>

#include "simgap/core/error.h"
#include "simgap/core/text.h"
#include "simgap/core/units.h"
#include "simgap/report/html/result_page.h"

namespace simgap {
namespace {

/// What a page does not look at of a long list is left in the file.
Json readObject(const std::filesystem::path& file) {
  Json json = readJson(file, [](std::string_view format) {
    const ResultPage* const page = findPage(format);
    return page == nullptr ? kWholeList : page->most_listed;
  });
  if (!json.is_object()) throw DataError(fmt::format("{}: found no JSON object, expected one", file.string()));
  return json;
}

/// What a table writes where there is no finite number.
bool unknown(const std::string& text) {
  return text.empty() || text == "nan" || text == "-nan" || text == "inf" || text == "-inf";
}

std::vector<double> parseNumbers(const CsvTable& table, const std::string& column, const std::vector<std::size_t>& rows,
                                 const std::vector<std::string>& texts) {
  std::vector<double> numbers;
  numbers.reserve(rows.size());
  for (const std::size_t row : rows) {
    const std::string& text = texts[row];
    const auto number = unknown(text) ? std::numeric_limits<double>::quiet_NaN() : parseNumber(text);
    if (!number) table.fail(row, fmt::format("{}: found '{}', expected a number", column, text));
    numbers.push_back(*number);
  }
  return numbers;
}

}  // namespace

ResultFiles::ResultFiles(std::filesystem::path directory, const Json& run) : directory_(std::move(directory)) {
  for (const char* name : {"run.json", "result.json"}) {
    if (has(name)) continue;
    throw ConfigError(fmt::format("{}: found no {}, expected the directory of a run that has ended with a result",
                                  directory_.string(), name));
  }
  result_ = readObject(directory_ / "result.json");
  run_ = run.is_null() ? readObject(directory_ / "run.json") : run;
}

bool ResultFiles::has(std::string_view name) const { return std::filesystem::exists(directory_ / name); }

std::string ResultFiles::input(std::string_view role, std::string_view otherwise) const {
  for (const Json& input : run_.value("inputs", Json::array())) {
    if (input.value("role", "") == role) return shellWord(input.value("file", ""));
  }
  return std::string(otherwise);
}

std::string ResultFiles::path(std::string_view name) const {
  const std::filesystem::path directory = run_.value("directory", directory_.string());
  return shellWord((directory / name).string());
}

CsvTable ResultFiles::table(std::string_view name) const { return CsvTable::load(directory_ / name); }

std::vector<double> numbersOf(const CsvTable& table, const std::string& column) {
  const std::vector<std::string> texts = table.text(column);
  std::vector<std::size_t> rows(texts.size());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = i;
  return parseNumbers(table, column, rows, texts);
}

std::vector<double> numbersWhere(const CsvTable& table, const std::string& column, const std::string& key,
                                 const std::string& value) {
  const std::vector<std::string> texts = table.text(column), keys = table.text(key);
  std::vector<std::size_t> rows;
  for (std::size_t i = 0; i < keys.size(); ++i) {
    if (keys[i] == value) rows.push_back(i);
  }
  return parseNumbers(table, column, rows, texts);
}

std::vector<std::string> distinctOf(const CsvTable& table, const std::string& column) {
  std::vector<std::string> seen;
  for (const std::string& text : table.text(column)) {
    if (std::ranges::find(seen, text) == seen.end()) seen.push_back(text);
  }
  return seen;
}

}  // namespace simgap
