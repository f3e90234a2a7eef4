#include <fmt/format.h>
#include <fmt/ranges.h>
#include <glog/logging.h>
#include <malloc.h>

#include <algorithm>
#include <csignal>
#include <cstdio>
#include <iostream>
#include <new>
#include <system_error>

#include "help.h"
#include "shell_files.h"
#include "simgap/cli/command.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/memory.h"
#include "simgap/core/progress.h"
#include "simgap/core/ranks.h"
#include "simgap/core/text.h"
#include "simgap/core/units.h"
#include "simgap/version.h"

namespace {

using simgap::Command;
using simgap::ExitCode;

using Actions = std::vector<std::pair<CLI::App*, std::function<ExitCode()>>>;

/// One line of a length that can be read, whatever names of files and poses hold; a terminal breaks it between words.
int fail(ExitCode code, std::string_view sentence) {
  constexpr std::size_t kLongest = 2000;
  simgap::printSentence("simgap: " + simgap::printable(simgap::abridged(sentence, kLongest)));
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

/// All commands with their options, and what runs them.
Actions defineCommands(CLI::App& app, const std::vector<std::string>& argv) {
  app.formatter(std::make_shared<simgap::HelpFormatter>());
  app.set_version_flag("--version", fmt::format("simgap {} ({})", simgap::kVersion, simgap::kGitHash));
  app.require_subcommand(1);
  app.footer(
      "\nBegin with:\n  simgap calibrate data/arm/arm.yaml --poses data/arm/poses_calibration.csv\n"
      "Each command explains itself: simgap calibrate --help");
  Actions actions;
  for (const Command* command : simgap::commands::all()) {
    CLI::App* sub = app.add_subcommand(command->name, command->summary);
    sub->footer(std::string("\nExample:\n") + command->example);
    actions.emplace_back(sub, command->define(*sub, argv));
  }
  return actions;
}

std::string didYouMean(const std::string& word, const std::vector<std::string>& names) {
  const std::string nearest = simgap::nearestName(word, names);
  return nearest.empty() ? "" : fmt::format("; did you mean {}?", nearest);
}

/// An option that the command does not have: what else is wrong often follows from it. Empty when all are known.
std::string unknownOption(const CLI::App& command, const std::vector<std::string>& argv) {
  std::vector<std::string> names;
  for (const CLI::Option* option : command.get_options()) {
    for (const std::string& name : option->get_lnames()) names.push_back("--" + name);
  }
  for (const std::string& word : argv) {
    const std::string name = word.substr(0, word.find('='));
    if (!name.starts_with("--") || name == "--" || std::ranges::find(names, name) != names.end()) continue;
    return fmt::format("found {}, expected an option of {}{}", name, command.get_name(), didYouMean(name, names));
  }
  return {};
}

/// What is wrong with a command line, and where help stands.
int failUsage(const CLI::App& app, const CLI::ParseError& error, const std::vector<std::string>& argv) {
  const std::vector<CLI::App*> begun = app.get_subcommands();
  if (!begun.empty()) {
    const std::string unknown = unknownOption(*begun.front(), argv);
    return fail(ExitCode::kUsage, fmt::format("{} (see simgap {} --help)", unknown.empty() ? error.what() : unknown,
                                              begun.front()->get_name()));
  }
  std::vector<std::string> names;
  for (const CLI::App* command : app.get_subcommands([](const CLI::App*) { return true; })) {
    names.push_back(command->get_name());
  }
  if (argv.size() < 2 || argv[1].starts_with('-')) {
    return fail(ExitCode::kUsage, std::string(error.what()) + " (see simgap --help)");
  }
  const std::string meant = didYouMean(argv[1], names);
  return fail(ExitCode::kUsage,
              fmt::format("found the command '{}', expected one of {}{}", argv[1], fmt::join(names, ", "), meant));
}

int run(const std::vector<std::string>& argv) {
  CLI::App app("simgap: closes the gap between a simulated tendon-driven robot and the real one", "simgap");
  const Actions actions = defineCommands(app, argv);
  if (argv.size() == 3 && argv[1] == simgap::kWriteShellFiles) {
    simgap::writeShellFiles(app, argv[2]);
    return 0;
  }
  try {
    std::vector<std::string> reversed(argv.rbegin(), argv.rend() - 1);  // CLI11 takes them from the back
    app.parse(reversed);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) return app.exit(error);  // --help, --version
    return failUsage(app, error, argv);
  }
  for (const auto& [sub, action] : actions) {
    if (sub->parsed()) return static_cast<int>(action());
  }
  return static_cast<int>(ExitCode::kUsage);
}

/// Runs the program; on several ranks all of them, and the first one speaks. \param failure  a sentence, or empty
int runOnRanks(int argc, char** argv, std::string& failure) try {
  simgap::joinRanks();
  return flushed(run({argv, argv + argc}));
} catch (const simgap::Error& error) {
  return fail(error.code(), failure = error.what());
} catch (const std::bad_alloc&) {
  return fail(ExitCode::kUsage, failure = simgap::kNoMemory);
} catch (const std::system_error& error) {  // a folder that may not be looked into, no more threads
  return fail(ExitCode::kUsage, failure = std::string("the system refused: ") + error.what());
} catch (const std::exception& error) {
  failure = std::string("internal error (a bug in simgap, please report it): ") + error.what();
  return fail(ExitCode::kInternal, failure);
}

}  // namespace

int main(int argc, char** argv) {
  mallopt(M_MMAP_THRESHOLD, 1 << 18);  // the columns of a log go back to the system as soon as they are freed,
  mallopt(M_TRIM_THRESHOLD, 1 << 26);  // the small ones of chunks stay, or every chunk would fault its pages in anew
  FLAGS_minloglevel = google::GLOG_FATAL;  // Ceres' log; what matters of it is in its summaries
  simgap::installInterruptHandlers();
  simgap::installNoMemoryHandler();
  ignoreWriteSignals();
  std::string failure;
  const int code = runOnRanks(argc, argv, failure);
  return simgap::leaveRanks(code, failure);
}
