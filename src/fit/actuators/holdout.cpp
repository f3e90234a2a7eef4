#include "simgap/fit/actuators/holdout.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "option_text.h"
#include "simgap/core/error.h"
#include "simgap/core/units.h"

namespace simgap {
namespace {

/// The rows whose cell in a column is one of the values, shape (rows).
std::vector<bool> rowsNamed(const NamedText& named, const CsvTable& table) {
  const std::vector<std::string> wanted = splitText(named.value, ',');
  std::set<std::string> missing(wanted.begin(), wanted.end());
  std::vector<bool> rows(table.rows());
  const auto compare = [&](const auto& cells, const auto& values) {
    for (std::size_t i = 0; i < cells.size(); ++i) {
      for (std::size_t k = 0; k < values.size(); ++k) {
        if (cells[i] != values[k]) continue;
        rows[i] = true;
        missing.erase(wanted[k]);
      }
    }
  };
  if (table.has(named.name) && table.isNumeric(named.name)) {
    std::vector<double> values;
    for (const std::string& value : wanted) values.push_back(parseNumber(value).value_or(std::nan("")));
    compare(table.quantity(named.name, ""), values);
  } else {
    compare(table.text(named.name), wanted);
  }
  if (!missing.empty()) {
    throw DataError(fmt::format("{}: found no row whose {} is {}, expected what --holdout names", table.name(),
                                named.name, fmt::join(missing, ", ")));
  }
  return rows;
}

}  // namespace

Holdout readHoldout(const std::string& text, const CsvTable& table) {
  Holdout holdout;
  if (text.empty()) return holdout;
  if (const auto fraction = parseNumber(text)) {
    if (!(*fraction > 0.0 && *fraction < 1.0)) {
      throw ConfigError(fmt::format("--holdout: found {}, expected a fraction between 0 and 1", text));
    }
    holdout.fraction = *fraction;
    holdout.words = fmt::format("{:.0f} % of the blocks", 100.0 * *fraction);
    return holdout;
  }
  holdout.rows = rowsNamed(splitNamed("--holdout", text, "a fraction of the blocks or COLUMN=VALUE,…"), table);
  holdout.words = text;
  return holdout;
}

std::vector<bool> fittedRows(const Holdout& holdout, std::span<const Block> blocks, std::span<const std::size_t> row) {
  std::vector<bool> fitted(row.size(), true);
  if (!holdout.rows.empty()) {
    for (std::size_t i = 0; i < row.size(); ++i) fitted[i] = !holdout.rows[row[i]];
  } else if (holdout.fraction) {
    // Spread evenly: block b is held out when the running share passes a whole number there.
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const double share = *holdout.fraction;
      const bool out =
          std::floor(static_cast<double>(b + 1) * share + 0.5) > std::floor(static_cast<double>(b) * share + 0.5);
      for (std::size_t i = blocks[b].begin; out && i < blocks[b].end; ++i) fitted[i] = false;
    }
  }
  const auto held_out = std::ranges::count(fitted, false);
  if (holdout.any() && (held_out == 0 || held_out == std::ssize(fitted))) {
    throw DataError(
        fmt::format("--holdout {} holds out {} of {} rows, expected some but not all (shorter blocks: "
                    "--block-s)",
                    holdout.words, held_out, fitted.size()));
  }
  return fitted;
}

std::vector<bool> fittedRows(const Holdout& holdout, std::span<const Block> blocks) {
  std::vector<std::size_t> row(blocks.empty() ? 0 : blocks.back().end);
  std::iota(row.begin(), row.end(), std::size_t{0});
  return fittedRows(holdout, blocks, row);
}

JudgedRows judgedRows(const Holdout& holdout, std::span<const Block> blocks) {
  constexpr std::size_t kFewestBlocks = 5;  // one of them is a fifth
  Holdout judged_by = holdout;
  if (!holdout.any()) judged_by = {0.2, {}, "20 % of the blocks, before the final fit to all rows"};
  JudgedRows rows{std::vector<bool>(blocks.empty() ? 0 : blocks.back().end, true), judged_by.words, !holdout.any()};
  if (blocks.size() >= kFewestBlocks || holdout.any()) rows.fitted = fittedRows(judged_by, blocks);
  return rows;
}

double blockSeconds(const std::optional<double>& asked, double duration) {
  constexpr double kLongest = 20.0;
  return asked.value_or(duration > 0.0 ? std::min(kLongest, duration / 10.0) : kLongest);
}

}  // namespace simgap
