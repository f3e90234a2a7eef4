/// \file
/// A command of simgap: one file in src/cli/commands, found by CMake.
#pragma once

#include <CLI/CLI.hpp>
#include <functional>
#include <span>
#include <string>
#include <vector>

#include "simgap/core/error.h"

namespace simgap {

struct Command {
  const char* name;
  const char* summary;  ///< one line
  const char* example;  ///< shown below the options
  /// Adds the options to `app` and returns what runs after parsing. `argv` is the whole command line, for run.json.
  std::function<ExitCode()> (*define)(CLI::App& app, const std::vector<std::string>& argv);
};

namespace commands {
std::span<const Command* const> all();
}

}  // namespace simgap
