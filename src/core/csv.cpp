#include "simgap/core/csv.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <optional>
#include <unordered_set>
#include <utility>

#include "csv_cells.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/run_directory.h"
#include "simgap/core/text.h"
#include "simgap/core/units.h"

namespace simgap {
namespace {

constexpr double kBadCell = std::numeric_limits<double>::quiet_NaN();
constexpr std::uint32_t kHeaderLine = 1;
constexpr std::size_t kRowsUnasked = 4096;  // rows between two looks for an interrupt

void requireHeaders(const std::vector<std::string>& headers, const std::string& name) {
  std::unordered_set<std::string_view> seen;
  for (std::size_t i = 0; i < headers.size(); ++i) {
    if (headers[i].empty()) {
      failInCsv(name, kHeaderLine, fmt::format("column {} of the header has no name, expected one", i + 1));
    }
    if (!seen.insert(headers[i]).second) {
      failInCsv(name, kHeaderLine, fmt::format("found the column {} twice, expected it once", abridged(headers[i])));
    }
  }
}

std::string didYouMean(const std::string& nearest) {
  return nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest);
}

std::vector<std::string> renamed(const std::vector<std::string>& headers,
                                 const std::map<std::string, std::string>& rename, const std::string& name) {
  std::vector<std::string> result = headers;
  std::vector<bool> taken(headers.size());
  for (const auto& [canonical, column] : rename) {
    const auto found = std::ranges::find(headers, column);
    if (found == headers.end()) {
      failInCsv(name, kHeaderLine,
                fmt::format("found no column {} to read as {}, expected one of {}{}", column, canonical,
                            listed(headers), didYouMean(nearestName(column, headers))));
    }
    const auto index = static_cast<std::size_t>(found - headers.begin());
    if (taken[index]) {
      failInCsv(name, kHeaderLine,
                fmt::format("the column {} cannot be both {} and {}", column, result[index], canonical));
    }
    taken[index] = true;
    result[index] = canonical;
  }
  return result;
}

}  // namespace

/// Reads the rows into columns in one pass.
class CsvParser {
 public:
  CsvParser(std::string text, const std::string& name, const CsvOptions& options)
      : options_(options),
        text_(std::make_shared<const std::string>(std::move(text))),
        name_(name),
        cells_(*text_, name_) {}

  CsvTable parse() {
    readHeader();
    while (!cells_.atEnd()) {
      readRow();
      if (rows_ % kRowsUnasked == 0) stopIfInterrupted();
    }
    for (Column& column : columns_) {
      if (column.kind == Kind::kUndecided) column = {Kind::kText, {}};
    }
    if (options_.skip_bad_rows) dropBadRows();
    return table();
  }

 private:
  enum class Kind : std::uint8_t { kUndecided, kNumber, kText };  ///< undecided: only empty cells so far
  struct Column {
    Kind kind = Kind::kUndecided;
    std::vector<double> numbers;  ///< empty for text
  };

  void readHeader() {
    if (cells_.atEnd()) failInCsv(name_, kHeaderLine, "found an empty file, expected a header row");
    headers_ = cells_.nextRow();
    if (headers_.size() > 1 && headers_.back().empty()) headers_.pop_back();
    requireHeaders(headers_, name_);
    headers_ = renamed(headers_, options_.rename, name_);
    requireHeaders(headers_, name_);
    columns_.resize(headers_.size());
    kinds_before_.resize(headers_.size());
    most_rows_ = cells_.mostRowsLeft(headers_.size());
  }

  void readRow() {
    std::ranges::transform(columns_, kinds_before_.begin(), &Column::kind);
    const std::uint32_t line = cells_.line();
    std::size_t count = 0;
    bool last = false;
    while (!last && count < columns_.size()) {
      last = readCell(columns_[count]);
      ++count;
    }
    while (!last) {
      const CsvCell cell = cells_.next();
      last = cell.last;
      // What ends every line with a separator (PLCs, LabVIEW) has no cell behind it.
      if (!last || count > columns_.size() || !cell.raw.empty()) ++count;
    }
    if (count == columns_.size()) {
      acceptRow(line);
    } else if (options_.skip_bad_rows) {
      takeRowBack();
    } else {
      failInCsv(name_, line,
                fmt::format("found {} cells, expected {}{}", count, columns_.size(),
                            columns_.size() == 1 ? ": line 1 has to name the columns; is it a title?" : ""));
    }
  }

  /// True at the last cell of a row.
  bool readCell(Column& column) {
    double value = 0.0;
    bool last = false;
    if (column.kind == Kind::kNumber && cells_.nextNumber(value, last)) {
      column.numbers.push_back(value);
      return last;
    }
    const CsvCell cell = cells_.next();
    if (column.kind == Kind::kText) return cell.last;
    const std::optional<double> number = cell.number(cells_.decimal());
    if (column.kind == Kind::kUndecided && !cell.raw.empty()) decide(column, number.has_value());
    if (column.kind != Kind::kText) column.numbers.push_back(number.value_or(kBadCell));
    return cell.last;
  }

  void decide(Column& column, bool number) {
    column.kind = number ? Kind::kNumber : Kind::kText;
    if (number) {
      column.numbers.reserve(most_rows_);
    } else {
      column.numbers = {};
    }
  }

  void acceptRow(std::uint32_t line) {
    if (lines_.empty() && line != rows_ + kHeaderLine + 1) writeOutLines();
    if (!lines_.empty() || line != rows_ + kHeaderLine + 1) lines_.push_back(line);
    ++rows_;
  }

  /// From here on rows do not stand on the line after the one before.
  void writeOutLines() {
    lines_.resize(rows_);
    std::iota(lines_.begin(), lines_.end(), kHeaderLine + 1);
  }

  /// Forgets a ragged row, and what its cells said about the columns.
  void takeRowBack() {
    for (std::size_t c = 0; c < columns_.size(); ++c) {
      if (columns_[c].kind != kinds_before_[c]) columns_[c] = {Kind::kUndecided, std::vector<double>(rows_, kBadCell)};
      if (columns_[c].kind != Kind::kText) columns_[c].numbers.resize(rows_);
    }
    ++skipped_;
  }

  void dropBadRows() {
    if (lines_.empty()) writeOutLines();
    std::size_t kept = 0;
    for (std::size_t row = 0; row < rows_; ++row) {
      const auto is_bad = [&](const Column& column) {
        return column.kind == Kind::kNumber && std::isnan(column.numbers[row]);
      };
      if (std::ranges::any_of(columns_, is_bad)) continue;
      for (Column& column : columns_) {
        if (column.kind == Kind::kNumber) column.numbers[kept] = column.numbers[row];
      }
      lines_[kept++] = lines_[row];
    }
    for (Column& column : columns_) {
      if (column.kind == Kind::kNumber) column.numbers.resize(kept);
    }
    lines_.resize(kept);
    skipped_ += rows_ - kept;
    rows_ = kept;
  }

  void scaleColumns(const std::vector<std::string>& headers) {
    for (const auto& [name, factor] : options_.scale) {
      Column& column = columns_[std::ranges::find(headers, name) - headers.begin()];
      if (column.kind == Kind::kText && rows_ > 0) {
        failInCsv(name_, kHeaderLine, fmt::format("column {} is to be multiplied, expected numbers in it", name));
      }
      for (double& value : column.numbers) value *= factor;
    }
  }

  CsvTable table() {
    CsvTable result;
    result.name_ = name_;
    result.rows_ = rows_;
    result.skipped_ = skipped_;
    result.headers_ = std::move(headers_);
    result.lines_ = std::move(lines_);
    result.text_ = text_;
    result.decimal_ = cells_.decimal();
    result.missing_advice_ = options_.missing_advice;
    scaleColumns(result.headers_);
    for (Column& column : columns_) {
      const bool number = column.kind == Kind::kNumber;
      result.numbers_.push_back(number ? std::make_shared<std::vector<double>>(std::move(column.numbers)) : nullptr);
    }
    return result;
  }

  const CsvOptions& options_;
  std::shared_ptr<const std::string> text_;
  std::string name_;
  CsvCells cells_;
  std::vector<std::string> headers_;
  std::vector<Column> columns_;
  std::vector<Kind> kinds_before_;  ///< of the columns, before the row that is read
  std::vector<std::uint32_t> lines_;
  std::size_t most_rows_ = 0;
  std::size_t rows_ = 0;
  std::size_t skipped_ = 0;
};

CsvTable CsvTable::load(const std::filesystem::path& file, const CsvOptions& options) {
  return parse(readFile(file), file.string(), options);
}

CsvTable CsvTable::parse(std::string text, const std::string& name, const CsvOptions& options) {
  return CsvParser(unpackCsv(std::move(text), name), name, options).parse();
}

std::size_t CsvTable::lineOf(std::size_t row) const { return lines_.empty() ? row + kHeaderLine + 1 : lines_[row]; }

bool CsvTable::has(std::string_view column) const { return std::ranges::find(headers_, column) != headers_.end(); }

bool CsvTable::isNumeric(std::string_view column) const {
  const auto found = std::ranges::find(headers_, column);
  if (found == headers_.end()) failMissing(column, "");
  return numbers_[found - headers_.begin()] != nullptr;
}

bool CsvTable::hasQuantity(std::string_view stem, std::string_view unit) const {
  return !matchQuantity(headers_, stem, unit).empty();
}

bool CsvTable::offersQuantity(std::string_view stem, std::string_view unit) const {
  if (hasQuantity(stem, unit)) return true;
  if (findUnitMistake(headers_, stem, unit)) failMissing(stem, unit);
  return false;
}

std::vector<std::size_t> CsvTable::badRows(std::string_view column) const {
  const auto found = std::ranges::find(headers_, column);
  if (found == headers_.end()) failMissing(column, "");
  std::vector<std::size_t> bad;
  const auto& numbers = numbers_[found - headers_.begin()];
  for (std::size_t row = 0; numbers && row < rows_; ++row) {
    if (std::isnan((*numbers)[row])) bad.push_back(row);
  }
  return bad;
}

CsvTable CsvTable::onlyRows(const std::vector<bool>& keep) const {
  CsvTable rest = *this;
  rest.lines_.clear();
  for (std::size_t row = 0; row < rows_; ++row) {
    if (keep[row]) rest.lines_.push_back(static_cast<std::uint32_t>(lineOf(row)));
  }
  rest.rows_ = rest.lines_.size();
  for (auto& column : rest.numbers_) {
    if (!column) continue;
    auto kept = std::make_shared<std::vector<double>>();
    kept->reserve(rest.rows_);
    for (std::size_t row = 0; row < rows_; ++row) {
      if (keep[row]) kept->push_back((*column)[row]);
    }
    column = std::move(kept);
  }
  return rest;
}

QuantityMatch CsvTable::matched(std::string_view stem, std::string_view unit) const {
  const std::vector<QuantityMatch> matches = matchQuantity(headers_, stem, unit);
  if (matches.empty()) failMissing(stem, unit);
  if (matches.size() > 1) {
    failInCsv(name_, kHeaderLine,
              fmt::format("found both {} and {}, expected only one of them", headers_[matches[0].index],
                          headers_[matches[1].index]));
  }
  // A column is text because its first cell is empty or no number, so that cell is the one to blame.
  if (rows_ > 0 && !numbers_[matches[0].index]) failCell(0, matches[0].index);
  return matches[0];
}

std::vector<double> CsvTable::converted(std::vector<double> values, const QuantityMatch& match) const {
  const double largest = largestPlausible(match.unit);
  const auto bad = std::ranges::find_if(values, [](double value) { return std::isnan(value); });
  if (bad != values.end()) failCell(static_cast<std::size_t>(bad - values.begin()), match.index);
  const auto absurd = std::ranges::find_if(values, [&](double value) { return std::abs(value) > largest; });
  if (absurd != values.end()) {
    fail(static_cast<std::size_t>(absurd - values.begin()),
         fmt::format("column {}: found {:g}, expected a size of at most {:g} {}: is that the unit?",
                     abridged(headers_[match.index]), *absurd, largest, match.unit));
  }
  // Adding an offset of 0 would turn -0 into 0.
  if (!match.conversion.isIdentity()) std::ranges::transform(values, values.begin(), match.conversion);
  return values;
}

std::vector<double> CsvTable::quantity(std::string_view stem, std::string_view unit) const {
  const QuantityMatch match = matched(stem, unit);
  if (rows_ == 0) return {};
  return converted(*numbers_[match.index], match);
}

std::vector<double> CsvTable::takeQuantity(std::string_view stem, std::string_view unit) {
  const QuantityMatch match = matched(stem, unit);
  if (rows_ == 0) return {};
  std::shared_ptr<std::vector<double>>& column = numbers_[match.index];
  if (column.use_count() > 1) return converted(*column, match);
  return converted(std::move(*std::exchange(column, nullptr)), match);
}

std::vector<std::string> CsvTable::text(std::string_view name) const {
  const auto found = std::ranges::find(headers_, name);
  if (found == headers_.end()) failMissing(name, "");
  const auto index = found - headers_.begin();
  CsvCells cells(*text_, name_);
  cells.skipRow();
  std::vector<std::string> texts;
  texts.reserve(rows_);
  while (texts.size() < rows_) {
    if (cells.line() != lineOf(texts.size())) {
      cells.skipRow();  // a row that was left out
      continue;
    }
    for (std::ptrdiff_t column = 0; column < index; ++column) cells.next();
    const CsvCell cell = cells.next();
    texts.push_back(cell.text());
    if (!cell.last) cells.skipRow();
  }
  return texts;
}

void CsvTable::fail(std::size_t row, const std::string& sentence) const {
  failInCsv(name_, static_cast<std::uint32_t>(lineOf(row)), sentence);
}

void CsvTable::failMissing(std::string_view stem, std::string_view unit) const {
  if (const auto mistake = findUnitMistake(headers_, stem, unit)) {
    failInCsv(name_, kHeaderLine, fmt::format("column {}: {}", headers_[mistake->index], mistake->sentence));
  }
  std::vector<std::string> spellings;
  for (const std::string& suffix : unitsLike(unit)) spellings.push_back(quantityName(stem, suffix));
  if (spellings.empty()) spellings.emplace_back(stem);
  std::string nearest;
  for (std::size_t i = 0; i < spellings.size() && nearest.empty(); ++i) nearest = nearestName(spellings[i], headers_);
  failInCsv(name_, kHeaderLine,
            fmt::format("found no column {}, expected it among {}{}", fmt::join(spellings, " or "), listed(headers_),
                        nearest.empty() ? missing_advice_ : didYouMean(nearest)));
}

void CsvTable::failCell(std::size_t row, std::size_t column) const {
  const std::string found = text(headers_[column])[row];
  fail(row, fmt::format("column {}: found {}, expected a finite number{}", abridged(headers_[column]),
                        found.empty() ? "an empty cell" : fmt::format("'{}'", abridged(found)),
                        decimal_ == ',' ? " with a decimal comma, as other numbers of the file have it" : ""));
}

}  // namespace simgap
