/// \file
/// --help within 80 columns.
#pragma once

#include <CLI/CLI.hpp>
#include <string>

namespace simgap {

/// What an option takes, in plain words: "NUMBER > 0", "{bullet,equilibrium}"; empty for a flag.
std::string valueText(const CLI::Option& option);

/// The options of a command that --help shows, positionals first.
std::vector<const CLI::Option*> shownOptions(const CLI::App& command);

class HelpFormatter : public CLI::Formatter {
 public:
  HelpFormatter();
  std::string make_option(const CLI::Option* option, bool positional) const override;
  std::string make_subcommand(const CLI::App* command) const override;
  std::string make_option_opts(const CLI::Option* option) const override;
};

}  // namespace simgap
