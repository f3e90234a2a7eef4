#include "help.h"

#include <fmt/format.h>

#include <array>
#include <regex>

#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr std::size_t kDescriptionColumn = 28;

/// A name, and what it stands for behind it or, where it is too long, below.
std::string entry(const std::string& name, const std::string& description) {
  std::string text = "  " + name;
  bool below = textWidth(text) + 2 > kDescriptionColumn;
  if (!below) text += std::string(kDescriptionColumn - textWidth(text), ' ');
  for (const std::string& line : wordLines(description, kTextWidth - kDescriptionColumn)) {
    if (below) text += "\n" + std::string(kDescriptionColumn, ' ');
    text += line;
    below = true;
  }
  return text + "\n";
}

/// CLI11's names of types and checks, and plain ones.
std::string plainType(std::string type) {
  static const std::array<std::pair<std::regex, const char*>, 8> kPlain = {{
      {std::regex(R"(FLOAT:\(?POSITIVE\)?( AND \(FINITE\))?)"), "NUMBER>0"},
      {std::regex(R"(FLOAT:\(?NONNEGATIVE\)?( AND \(FINITE\))?)"), "NUMBER>=0"},
      {std::regex(R"(FLOAT:(FLOAT in|FINITE))"), "NUMBER"},
      {std::regex(R"(FLOAT)"), "NUMBER"},
      {std::regex(R"(UINT:UINT64|UINT:INT|INT:INT|UINT)"), "INT"},
      {std::regex(R"((INT|NUMBER)( in)? \[(\S+) - (\S+)\])"), "$1 $3…$4"},
      {std::regex(R"((TEXT|INT):\{)"), "{"},
      {std::regex(R"(^TEXT$)"), "TEXT"},
  }};
  for (const auto& [pattern, plain] : kPlain) type = std::regex_replace(type, pattern, plain);
  return type;
}

}  // namespace

std::string valueText(const CLI::Option& option) {
  if (option.get_type_size() == 0) return {};
  return plainType(option.get_type_name());
}

std::vector<const CLI::Option*> shownOptions(const CLI::App& command) {
  std::vector<const CLI::Option*> shown, named;
  for (const CLI::Option* option : command.get_options()) {
    if (option->get_group().empty()) continue;
    (option->get_positional() ? shown : named).push_back(option);
  }
  shown.insert(shown.end(), named.begin(), named.end());
  return shown;
}

HelpFormatter::HelpFormatter() {
  label("OPTIONS", "options");
  label("SUBCOMMAND", "COMMAND");
  label("Subcommands", "Commands");
}

std::string HelpFormatter::make_option_opts(const CLI::Option* option) const {
  std::string text = valueText(*option);
  if (option->get_type_size() == 0) return {};
  if (option->get_expected_max() == CLI::detail::expected_max_vector_size) {
    text += " ...";
  } else if (option->get_expected_min() > 1) {
    text += fmt::format(" x {}", option->get_expected());
  }
  return " " + text;
}

std::string HelpFormatter::make_option(const CLI::Option* option, bool positional) const {
  const std::string type = make_option_opts(option);
  const std::string name = make_option_name(option, positional) + (positional && type == " TEXT" ? "" : type);
  return entry(name, option->get_description() + (option->get_required() ? " (required)" : ""));
}

std::string HelpFormatter::make_subcommand(const CLI::App* command) const {
  return entry(command->get_name(), command->get_description());
}

}  // namespace simgap
