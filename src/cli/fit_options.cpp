#include "fit_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "simgap/core/error.h"
#include "simgap/core/units.h"
#include "simgap/core/yaml.h"

namespace simgap {
namespace {

struct Entry {
  std::string name, value;
};

Entry splitEntry(const std::string& option, const std::string& text, const char* expected) {
  const std::size_t equals = text.find('=');
  if (equals == std::string::npos || equals == 0 || equals + 1 == text.size()) {
    throw ConfigError(fmt::format("{}: found '{}', expected {}", option, text, expected));
  }
  return {text.substr(0, equals), text.substr(equals + 1)};
}

double number(const std::string& option, const std::string& text) {
  if (const auto value = parseNumber(text)) return *value;
  throw ConfigError(fmt::format("{}: found '{}', expected a number", option, text));
}

std::vector<std::string> split(const std::string& text, char separator) {
  std::vector<std::string> parts;
  std::size_t begin = 0;
  for (std::size_t end = 0; end != std::string::npos; begin = end + 1) {
    end = text.find(separator, begin);
    parts.push_back(text.substr(begin, end == std::string::npos ? end : end - begin));
  }
  return parts;
}

}  // namespace

void FitOptions::add(CLI::App& app) {
  app.add_option("--fix", fix, "NAME=VALUE: a parameter that is known; may be repeated")->allow_extra_args(false);
  app.add_option("--bounds", bounds, "NAME=LOWER:UPPER in SI; may be repeated")->allow_extra_args(false);
  app.add_option("--sessions", sessions, "fit these sessions only (comma-separated)")->delimiter(',');
  app.add_option("--holdout", holdout,
                 "keep rows from the fit and judge it by them: a fraction of the blocks (0.2), or COLUMN=VALUE,… "
                 "(session=5,6); default: cross-validation over blocks where it is cheap");
  app.add_option("--block-s", block_s, "length of the blocks that are held out together [s]")
      ->check(CLI::PositiveNumber & finiteNumber());
  app.add_option("--validate", validate, "another log to judge the fit by; may be repeated")->allow_extra_args(false);
}

std::map<std::string, double> FitOptions::fixed() const {
  std::map<std::string, double> values;
  for (const std::string& text : fix) {
    const Entry entry = splitEntry("--fix", text, "NAME=VALUE");
    values[entry.name] = number("--fix " + entry.name, entry.value);
  }
  return values;
}

std::map<std::string, Bounds> FitOptions::parameterBounds() const {
  std::map<std::string, Bounds> values;
  for (const std::string& text : bounds) {
    const Entry entry = splitEntry("--bounds", text, "NAME=LOWER:UPPER");
    const std::vector<std::string> parts = split(entry.value, ':');
    if (parts.size() != 2) throw ConfigError(fmt::format("--bounds: found '{}', expected NAME=LOWER:UPPER", text));
    const Bounds range{number("--bounds " + entry.name, parts[0]), number("--bounds " + entry.name, parts[1])};
    if (!(range.lower < range.upper)) {
      throw ConfigError(
          fmt::format("--bounds {}: found {}, expected a lower bound below the upper one", entry.name, entry.value));
    }
    values[entry.name] = range;
  }
  return values;
}

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
  const Entry entry = splitEntry("--holdout", text, "a fraction of the blocks or COLUMN=VALUE,…");
  const std::vector<std::string> wanted = split(entry.value, ',');
  std::set<std::string> missing(wanted.begin(), wanted.end());
  holdout.words = text;
  holdout.rows.resize(table.rows());
  const auto compare = [&](const auto& cells, const auto& values) {
    std::vector<bool> found(values.size(), false);
    for (std::size_t i = 0; i < cells.size(); ++i) {
      for (std::size_t k = 0; k < values.size(); ++k) {
        if (cells[i] == values[k]) holdout.rows[i] = found[k] = true;
      }
    }
    for (std::size_t k = 0; k < values.size(); ++k) {
      if (found[k]) missing.erase(wanted[k]);
    }
  };
  if (table.has(entry.name) && table.isNumeric(entry.name)) {
    std::vector<double> values;
    for (const std::string& value : wanted) values.push_back(parseNumber(value).value_or(std::nan("")));
    compare(table.quantity(entry.name, ""), values);
  } else {
    compare(table.text(entry.name), wanted);
  }
  if (!missing.empty()) {
    throw DataError(fmt::format("{}: found no row whose {} is {}, expected what --holdout names", table.name(),
                                entry.name, fmt::join(missing, ", ")));
  }
  return holdout;
}

std::vector<bool> heldOutRows(const Holdout& holdout, std::span<const Block> blocks, std::span<const std::size_t> row) {
  std::vector<bool> held(row.size(), false);
  if (!holdout.rows.empty()) {
    for (std::size_t i = 0; i < row.size(); ++i) held[i] = holdout.rows[row[i]];
  } else if (holdout.fraction) {
    // Spread evenly: block b is held out when the running share passes a whole number there.
    for (std::size_t b = 0; b < blocks.size(); ++b) {
      const double share = *holdout.fraction;
      const bool out =
          std::floor(static_cast<double>(b + 1) * share + 0.5) > std::floor(static_cast<double>(b) * share + 0.5);
      for (std::size_t i = blocks[b].begin; out && i < blocks[b].end; ++i) held[i] = true;
    }
  }
  const auto count = std::ranges::count(held, true);
  if (holdout.any() && (count == 0 || count == static_cast<std::ptrdiff_t>(held.size()))) {
    throw DataError(
        fmt::format("--holdout {} holds out {} of {} rows, expected some but not all (shorter blocks: "
                    "--block-s)",
                    holdout.words, count, held.size()));
  }
  return held;
}

std::string resolvedOptions(const CLI::App& app) {
  std::string text = "# every other option has its default\n";
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0) continue;
    std::vector<std::string> words;
    for (const std::string& word : option->results()) words.push_back(yamlText(word));
    text += fmt::format("{}: [{}]\n", option->get_single_name(), fmt::join(words, ", "));
  }
  return text;
}

void requireKnownParameters(const FitOptions& options, const std::vector<ParameterSpec>& known) {
  std::vector<std::string> names;
  for (const ParameterSpec& p : known) {
    if (std::ranges::find(names, p.name) == names.end()) names.push_back(p.name);
  }
  const auto require = [&](const std::string& option, const std::string& name) {
    if (std::ranges::find(names, name) != names.end()) return;
    throw ConfigError(
        fmt::format("{}: found the parameter {}, expected one of {}", option, name, fmt::join(names, ", ")));
  };
  for (const auto& [name, value] : options.fixed()) require("--fix", name);
  for (const auto& [name, range] : options.parameterBounds()) require("--bounds", name);
}

}  // namespace simgap
