#include "simgap/fit/actuators/parameter_choices.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "option_text.h"
#include "simgap/core/error.h"
#include "simgap/core/units.h"
#include "simgap/core/yaml.h"

namespace simgap {
namespace {

double numberOption(const std::string& option, const std::string& text) {
  if (const auto value = parseNumber(text)) return *value;
  throw ConfigError(fmt::format("{}: found '{}', expected a number", option, text));
}

Bounds boundsOption(const NamedText& entry) {
  const std::string option = "--bounds " + entry.name;
  const std::vector<std::string> parts = splitText(entry.value, ':');
  if (parts.size() != 2) {
    throw ConfigError(fmt::format("--bounds: found '{}={}', expected NAME=LOWER:UPPER", entry.name, entry.value));
  }
  const Bounds range{numberOption(option, parts[0]), numberOption(option, parts[1])};
  if (!(range.lower < range.upper)) {
    throw ConfigError(fmt::format("{}: found {}, expected a lower bound below the upper one", option, entry.value));
  }
  return range;
}

[[noreturn]] void failTwice(const std::string& name) {
  throw ConfigError(fmt::format("found {} twice among --fix and --bounds, expected it once", name));
}

/// What a parameter can be, by the bounds that its model gives it.
const Range& possibleRange(const ParameterSpec& own) {
  if (own.lower < 0.0) return kAnyNumber;
  if (own.lower == 0.0) return kNonNegative;
  return own.unit == "1" && own.upper == 1.0 ? kEfficiency : kPositive;
}

void requirePossible(const ParameterChoices& choices, const ParameterSpec& own) {
  const Range& range = possibleRange(own);
  const auto fixed = choices.fixed.find(own.name);
  if (fixed != choices.fixed.end()) {
    const double value = fixed->second;
    const bool above = range.lower_open ? value > range.lower : value >= range.lower;
    if (above && value <= range.upper) return;
    throw ConfigError(fmt::format("--fix {}: found {:g}, expected {}", own.name, value, range.expected));
  }
  const auto bounds = choices.bounds.find(own.name);
  if (bounds == choices.bounds.end()) return;
  const auto [lower, upper] = bounds->second;  // 0 as the lower one means next to nothing
  if (lower >= range.lower && upper <= range.upper) return;
  throw ConfigError(
      fmt::format("--bounds {}: found {:g}:{:g}, expected each to be {}", own.name, lower, upper, range.expected));
}

}  // namespace

ParameterChoices readParameterChoices(std::span<const std::string> fix, std::span<const std::string> bounds) {
  ParameterChoices choices;
  for (const std::string& text : fix) {
    const NamedText entry = splitNamed("--fix", text, "NAME=VALUE");
    const double value = numberOption("--fix " + entry.name, entry.value);
    if (!choices.fixed.emplace(entry.name, value).second) failTwice(entry.name);
  }
  for (const std::string& text : bounds) {
    const NamedText entry = splitNamed("--bounds", text, "NAME=LOWER:UPPER");
    const bool first = choices.bounds.emplace(entry.name, boundsOption(entry)).second;
    if (!first || choices.fixed.contains(entry.name)) failTwice(entry.name);
  }
  return choices;
}

void requireKnown(const ParameterChoices& choices, std::span<const std::string> known) {
  std::vector<std::string> names;  // each once, in their order, for the message
  for (const std::string& name : known) {
    if (std::ranges::find(names, name) == names.end()) names.push_back(name);
  }
  const auto require = [&](const char* option, const std::string& name) {
    if (std::ranges::find(names, name) != names.end()) return;
    throw ConfigError(
        fmt::format("{}: found the parameter {}, expected one of {}", option, name, fmt::join(names, ", ")));
  };
  for (const auto& [name, value] : choices.fixed) require("--fix", name);
  for (const auto& [name, range] : choices.bounds) require("--bounds", name);
}

void constrain(const ParameterChoices& choices, std::span<ParameterSpec> parameters) {
  constexpr double kNextToNothing = 1e-6;  // of the upper bound: a lower one of 0 for what cannot be 0
  for (ParameterSpec& p : parameters) {
    requirePossible(choices, p);
    if (const auto bounds = choices.bounds.find(p.name); bounds != choices.bounds.end()) {
      const auto [lower, upper] = bounds->second;
      p.lower = lower == 0.0 && p.lower > 0.0 ? std::min(p.lower, kNextToNothing * upper) : lower;
      p.upper = upper;
    }
    p.fixed = p.fixed || choices.fixed.contains(p.name);
  }
}

void fixValues(std::span<const ParameterSpec> parameters, const std::map<std::string, double>& fixed,
               std::span<double> theta) {
  for (std::size_t i = 0; i < theta.size(); ++i) {
    if (const auto known = fixed.find(parameters[i].name); known != fixed.end()) theta[i] = known->second;
  }
}

}  // namespace simgap
