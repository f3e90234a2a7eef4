#include "simgap/fit/actuators/parameter_choices.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "option_text.h"
#include "simgap/core/error.h"
#include "simgap/core/units.h"

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

}  // namespace

ParameterChoices readParameterChoices(std::span<const std::string> fix, std::span<const std::string> bounds) {
  ParameterChoices choices;
  for (const std::string& text : fix) {
    const NamedText entry = splitNamed("--fix", text, "NAME=VALUE");
    choices.fixed[entry.name] = numberOption("--fix " + entry.name, entry.value);
  }
  for (const std::string& text : bounds) {
    const NamedText entry = splitNamed("--bounds", text, "NAME=LOWER:UPPER");
    choices.bounds[entry.name] = boundsOption(entry);
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
  for (ParameterSpec& p : parameters) {
    if (const auto bounds = choices.bounds.find(p.name); bounds != choices.bounds.end()) {
      p.lower = bounds->second.lower;
      p.upper = bounds->second.upper;
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
