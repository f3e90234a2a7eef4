#include <fmt/format.h>

#include <iostream>

#include "simgap/cli/command.h"
#include "simgap/core/interrupt.h"
#include "simgap/version.h"

namespace {

using simgap::Command;
using simgap::ExitCode;

int run(const std::vector<std::string>& argv) {
  CLI::App app("simgap: closes the gap between a simulated tendon-driven robot and the real one");
  app.set_version_flag("--version", fmt::format("simgap {} ({})", simgap::kVersion, simgap::kGitHash));
  app.require_subcommand(1);
  app.footer("\nBegin with:\n  simgap calibrate arm.yaml --poses poses.csv\nEach command explains itself: simgap calibrate --help");

  std::vector<std::pair<CLI::App*, std::function<ExitCode()>>> actions;
  for (const Command* command : simgap::commands::all()) {
    CLI::App* sub = app.add_subcommand(command->name, command->summary);
    sub->footer(std::string("\nExample:\n") + command->example);
    actions.emplace_back(sub, command->define(*sub, argv));
  }
  try {
    std::vector<std::string> reversed(argv.rbegin(), argv.rend() - 1);  // CLI11 takes them from the back
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    std::cerr << "simgap: " << error.what() << " (see simgap --help)\n";
    return static_cast<int>(ExitCode::kUsage);
  }
  for (const auto& [sub, action] : actions) {
    if (sub->parsed()) return static_cast<int>(action());
  }
  return static_cast<int>(ExitCode::kUsage);
}

}  // namespace

int main(int argc, char** argv) try {
  simgap::installInterruptHandlers();
  return run({argv, argv + argc});
} catch (const simgap::Error& error) {
  std::cerr << "simgap: " << error.what() << '\n';
  return static_cast<int>(error.code());
} catch (const std::exception& error) {
  std::cerr << "simgap: internal error (a bug in simgap, please report it): " << error.what() << '\n';
  return static_cast<int>(ExitCode::kInternal);
}
