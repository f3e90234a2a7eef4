#include <fmt/format.h>
#include <glog/logging.h>
#include <malloc.h>

#include <csignal>
#include <cstdio>
#include <iostream>
#include <new>
#include <system_error>

#include "simgap/cli/command.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/text.h"
#include "simgap/version.h"

namespace {

using simgap::Command;
using simgap::ExitCode;

/// One line of a length that can be read, whatever names of files and poses hold.
int fail(ExitCode code, std::string_view sentence) {
  constexpr std::size_t kLongest = 2000;
  std::cerr << "simgap: " << simgap::printable(simgap::abridged(sentence, kLongest)) << '\n';
  return static_cast<int>(code);
}

/// A result that nobody could take is no success: plans, --help and the like go through buffers until here.
int flushed(int code) {
  const bool good = std::cout.flush().good() && std::fflush(stdout) == 0 && std::ferror(stdout) == 0;
  if (good || code != 0) return code;
  return fail(ExitCode::kUsage, "the standard output cannot be written");
}

/// A file that grows too large, and a reader that goes away, are errors of write with a reason, not the end of the
/// process in the middle of a run.
void ignoreWriteSignals() {
  std::signal(SIGXFSZ, SIG_IGN);
  std::signal(SIGPIPE, SIG_IGN);
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
  ignoreWriteSignals();
  return flushed(run({argv, argv + argc}));
} catch (const simgap::Error& error) {
  return fail(error.code(), error.what());
} catch (const std::bad_alloc&) {
  return fail(ExitCode::kUsage, "not enough memory: the input needs more than the system grants");
} catch (const std::system_error& error) {  // a folder that may not be looked into, no more threads
  return fail(ExitCode::kUsage, std::string("the system refused: ") + error.what());
} catch (const std::exception& error) {
  return fail(ExitCode::kInternal, std::string("internal error (a bug in simgap, please report it): ") + error.what());
}
