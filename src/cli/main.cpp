#include <fmt/format.h>
#include <glog/logging.h>
#include <malloc.h>

#include <algorithm>
#include <iostream>

#include "simgap/cli/command.h"
#include "simgap/core/interrupt.h"
#include "simgap/version.h"

namespace {

using simgap::Command;
using simgap::ExitCode;

/// One line, whatever names of files and poses hold.
int fail(ExitCode code, std::string sentence) {
  std::replace_if(
      sentence.begin(), sentence.end(), [](char c) { return c == '\n' || c == '\r'; }, ' ');
  std::cerr << "simgap: " << sentence << '\n';
  return static_cast<int>(code);
}

int run(const std::vector<std::string>& argv) {
  CLI::App app("simgap: closes the gap between a simulated tendon-driven robot and the real one", "simgap");
  app.set_version_flag("--version", fmt::format("simgap {} ({})", simgap::kVersion, simgap::kGitHash));
  app.require_subcommand(1);
  app.footer(
      "\nBegin with:\n  simgap calibrate arm.yaml --poses poses.csv\nEach command explains itself: simgap calibrate "
      "--help");

  std::vector<std::pair<CLI::App*, std::function<ExitCode()>>> actions;
  std::string names;
  for (const Command* command : simgap::commands::all()) {
    names += (names.empty() ? "" : ", ") + std::string(command->name);
    CLI::App* sub = app.add_subcommand(command->name, command->summary);
    sub->footer(std::string("\nExample:\n") + command->example);
    actions.emplace_back(sub, command->define(*sub, argv));
  }
  try {
    std::vector<std::string> reversed(argv.rbegin(), argv.rend() - 1);  // CLI11 takes them from the back
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    if (argv.size() > 1 && !argv[1].starts_with('-') && app.get_subcommands().empty()) {
      return fail(ExitCode::kUsage, fmt::format("found the command '{}', expected one of {}", argv[1], names));
    }
    return fail(ExitCode::kUsage, std::string(error.what()) + " (see simgap --help)");
  }
  for (const auto& [sub, action] : actions) {
    if (sub->parsed()) return static_cast<int>(action());
  }
  return static_cast<int>(ExitCode::kUsage);
}

}  // namespace

int main(int argc, char** argv) try {
  mallopt(M_MMAP_THRESHOLD, 1 << 18);  // the columns of a log go back to the system as soon as they are freed,
  mallopt(M_TRIM_THRESHOLD, 1 << 26);  // the small ones of chunks stay, or every chunk would fault its pages in anew
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres' log; what matters of it is in its summaries
  simgap::installInterruptHandlers();
  return run({argv, argv + argc});
} catch (const simgap::Error& error) {
  return fail(error.code(), error.what());
} catch (const std::exception& error) {
  return fail(ExitCode::kInternal, std::string("internal error (a bug in simgap, please report it): ") + error.what());
}
