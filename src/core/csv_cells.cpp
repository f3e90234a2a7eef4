#include "csv_cells.h"

#include <fast_float/fast_float.h>
#include <fmt/format.h>
#include <zlib.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <cstring>
#include <limits>
#include <memory>
#include <new>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/units.h"

namespace simgap {
namespace {

constexpr std::string_view kByteOrderMark = "\xEF\xBB\xBF";
constexpr std::string_view kGzipMagic = "\x1F\x8B";
constexpr int kGzipOnly = 15 + 16;  // window bits, see zlib.h
// What is denser is no table, whose times alone take a few bytes a row: it is refused before it takes the memory.
constexpr std::size_t kDensest = 200, kHarmless = std::size_t{64} << 20U;
constexpr unsigned kReadSize = 1U << 20;

/// What the header has most of outside quotes; a comma where it has one column only.
char separatorOf(std::string_view text) {
  std::size_t commas = 0, semicolons = 0, tabs = 0;
  bool quoted = false;
  for (const char character : text) {
    if (character == '"') quoted = !quoted;
    if (quoted) continue;
    if (character == '\n') break;
    commas += character == ',' ? 1 : 0;
    semicolons += character == ';' ? 1 : 0;
    tabs += character == '\t' ? 1 : 0;
  }
  if (commas >= std::max(semicolons, tabs)) return ',';
  return semicolons >= tabs ? ';' : '\t';
}

/// A comma between two digits is a decimal one where commas do not separate.
char decimalOf(std::string_view text, char separator) {
  const auto isDigit = [&](std::size_t at) { return at < text.size() && text[at] >= '0' && text[at] <= '9'; };
  if (separator == ',') return '.';
  for (std::size_t at = text.find(','); at != std::string_view::npos; at = text.find(',', at + 1)) {
    if (at > 0 && isDigit(at - 1) && isDigit(at + 1)) return ',';
  }
  return '.';
}

std::string_view nameOf(char separator) {
  if (separator == ';') return "a semicolon";
  return separator == ',' ? "a comma" : "a tab";
}

std::uint32_t linesIn(std::string_view text) { return static_cast<std::uint32_t>(std::ranges::count(text, '\n')); }

}  // namespace

void failInCsv(const std::string& file, std::uint32_t line, const std::string& sentence) {
  throw DataError(fmt::format("{}:{}: {}", file, line, sentence));
}

std::string unpackCsv(std::string packed, const std::string& file, std::size_t largest) {
  const std::string_view bytes = packed;
  if (!bytes.starts_with(kGzipMagic)) {
    if (file.ends_with(".gz")) failInCsv(file, 1, "found no gzip data, expected them by the name's ending");
    if (bytes.starts_with("\xFF\xFE") || bytes.starts_with("\xFE\xFF")) {
      failInCsv(file, 1, "found UTF-16 text, expected UTF-8: a spreadsheet saves it as \"CSV UTF-8\"");
    }
    return packed;
  }
  z_stream stream = {};
  if (inflateInit2(&stream, kGzipOnly) != Z_OK) throw std::bad_alloc();
  const std::unique_ptr<z_stream, int (*)(z_streamp)> guard(&stream, inflateEnd);
  stream.next_in = reinterpret_cast<Bytef*>(const_cast<char*>(bytes.data()));
  stream.avail_in = static_cast<uInt>(bytes.size());
  std::string text;
  std::string piece(kReadSize, '\0');
  int status = Z_OK;
  while (status == Z_OK) {
    stopIfInterrupted();
    stream.next_out = reinterpret_cast<Bytef*>(piece.data());
    stream.avail_out = kReadSize;
    status = inflate(&stream, Z_NO_FLUSH);
    text.append(piece, 0, kReadSize - stream.avail_out);
    if (text.size() > largest) {
      throw DataError(fmt::format("{}: found more than {} MiB of unpacked text, expected less", file, largest >> 20U));
    }
    if (text.size() > std::max(kHarmless, kDensest * (bytes.size() - stream.avail_in))) {
      throw DataError(
          fmt::format("{}: found gzip data that unpack to more than {} times their size, expected a table "
                      "(rows of one take a few bytes each)",
                      file, kDensest));
    }
    // Packed files may stand one behind the other.
    const std::string_view rest = bytes.substr(bytes.size() - stream.avail_in);
    if (status == Z_STREAM_END && rest.starts_with(kGzipMagic)) status = inflateReset(&stream);
  }
  if (status == Z_STREAM_END) return text;
  failInCsv(file, linesIn(text) + 1,
            status == Z_BUF_ERROR ? "the gzip data break off here, expected the rest of the file"
                                  : "the gzip data are damaged here, expected a valid stream");
}

bool isFormula(std::string_view text) {
  constexpr std::string_view kBegins = "=+-@\t\r";
  text.remove_prefix(std::min(text.find_first_not_of(kNoFormula), text.size()));  // its own apostrophes are kept
  return text.size() > 1 && kBegins.find(text[0]) != std::string_view::npos && !CsvCell{text}.number('.');
}

std::string CsvCell::text() const {
  std::string result;
  for (std::size_t i = 0; i < raw.size(); ++i) {
    result += raw[i];
    if (escaped && raw[i] == '"') ++i;  // its double
  }
  if (result.starts_with(kNoFormula) && isFormula(std::string_view(result).substr(1))) result.erase(0, 1);
  return result;
}

std::optional<double> CsvCell::number(char decimal) const {
  if (decimal == ',') {
    std::string pointed(raw);
    if (pointed.find('.') != std::string::npos) return std::nullopt;
    std::ranges::replace(pointed, ',', '.');
    return CsvCell{pointed}.number('.');
  }
  if (const auto finite = parseNumber(raw)) return finite;
  double value = 0.0;
  const char* const end = raw.data() + raw.size();
  const auto [stop, error] = fast_float::from_chars(raw.data(), end, value);
  if (error == std::errc::invalid_argument || stop != end) return std::nullopt;
  return std::numeric_limits<double>::quiet_NaN();
}

CsvCells::CsvCells(std::string_view text, const std::string& file) : file_(file) {
  if (text.starts_with(kByteOrderMark)) text.remove_prefix(kByteOrderMark.size());
  while (text.ends_with('\n')) {
    text.remove_suffix(1);
    if (text.ends_with('\r')) text.remove_suffix(1);
  }
  at_ = text.data();
  end_ = text.data() + text.size();
  separator_ = separatorOf(text);
  decimal_ = decimalOf(text, separator_);
  for (const char stop : {separator_, '\n', '\r', '"'}) stops_[static_cast<unsigned char>(stop)] = true;
}

bool CsvCells::separatorAt(const char* at, bool& last, std::size_t& length) const {
  last = at == end_ || *at != separator_;
  length = at == end_ ? 0 : 1;
  if (at == end_ || *at == separator_ || *at == '\n') return true;
  length = 2;
  return *at == '\r' && at + 1 != end_ && at[1] == '\n';
}

void CsvCells::step(const char* separator, std::size_t length, bool last) {
  at_ = separator + length;
  if (last && length > 0) ++line_;
  cell_due_ = !last && at_ == end_;
}

CsvCell CsvCells::next() {
  if (at_ != end_ && *at_ == '"') return quotedCell();
  const char* stop = at_;
  while (stop != end_ && !stops_[static_cast<unsigned char>(*stop)]) ++stop;
  CsvCell cell{std::string_view(at_, static_cast<std::size_t>(stop - at_))};
  std::size_t length = 0;
  if (!separatorAt(stop, cell.last, length)) {
    const bool quote = *stop == '"';
    failInCsv(file_, line_,
              quote ? "found a quote inside a cell without quotes, expected the whole cell quoted"
                    : "found a carriage return without a line feed, expected both");
  }
  step(stop, length, cell.last);
  return cell;
}

CsvCell CsvCells::quotedCell() {
  const std::uint32_t first_line = line_;
  const char* const begin = at_ + 1;
  const char* stop = begin;
  bool escaped = false;
  while (true) {
    stop = stop == end_ ? nullptr
                        : static_cast<const char*>(std::memchr(stop, '"', static_cast<std::size_t>(end_ - stop)));
    if (stop == nullptr) failInCsv(file_, first_line, "found a quoted cell without an end, expected a closing quote");
    if (stop + 1 == end_ || stop[1] != '"') break;
    escaped = true;
    stop += 2;
  }
  CsvCell cell{std::string_view(begin, static_cast<std::size_t>(stop - begin)), escaped};
  line_ += linesIn(cell.raw);
  std::size_t length = 0;
  if (!separatorAt(stop + 1, cell.last, length)) {
    failInCsv(file_, line_,
              fmt::format("found text behind a closing quote, expected {} or the end of the line", nameOf(separator_)));
  }
  step(stop + 1, length, cell.last);
  return cell;
}

bool CsvCells::nextNumber(double& value, bool& last) {
  const fast_float::parse_options options{fast_float::chars_format::general, decimal_};
  const auto [stop, error] = fast_float::from_chars_advanced(at_, end_, value, options);
  std::size_t length = 0;
  if (error != std::errc() || !std::isfinite(value) || !separatorAt(stop, last, length)) return false;
  step(stop, length, last);
  return true;
}

std::vector<std::string> CsvCells::nextRow() {
  std::vector<std::string> row;
  CsvCell cell;
  do {
    cell = next();
    row.push_back(cell.text());
  } while (!cell.last);
  return row;
}

void CsvCells::skipRow() {
  while (!next().last) {
  }
}

std::size_t CsvCells::mostRowsLeft(std::size_t columns) const {
  // A row ends in a line feed, and has a separator behind each cell.
  const std::string_view left(at_, static_cast<std::size_t>(end_ - at_));
  return std::min<std::size_t>(linesIn(left), left.size() / columns) + 1;
}

}  // namespace simgap
