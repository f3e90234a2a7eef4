#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <set>

#include "simgap/cli/command.h"
#include "simgap/cli/session.h"
#include "simgap/core/error.h"
#include "simgap/report/runs/run_comparison.h"

namespace simgap::commands::compare {
namespace {

struct Options {
  CommonOptions common;
  std::vector<std::filesystem::path> runs;
};

ExitCode run(const Options& options, const std::vector<std::string>& argv) {
  Session session("compare", options.common, argv);
  if (options.runs.size() < 2) throw ConfigError("found one run, expected two or more to compare");
  std::vector<RunFigures> runs;
  std::set<std::filesystem::path> seen;
  for (const std::filesystem::path& directory : options.runs) {
    std::error_code none;
    if (!seen.insert(std::filesystem::weakly_canonical(directory, none)).second) {
      throw ConfigError(fmt::format("found {} twice, expected every run once", directory.string()));
    }
    runs.push_back(readRun(directory));
    session.read("run", directory / "result.json");
  }
  const Json result = compareRuns(runs);
  if (options.common.dry_run) {
    session.print(fmt::format("would compare {} runs; nothing was written\n", runs.size()));
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  session.directory().write("parameters.csv", comparisonCsv(result));
  session.finish(result, comparisonText(result));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("RUN", options->runs, "result directories of one command, in the order of their recordings")
      ->required();
  options->common.add(app);
  return [options, argv] { return run(*options, argv); };
}

}  // namespace

extern const Command entry;
const Command entry{"compare", "runs of several days, units or robots: what is common, what differs, since when",
                    "  simgap fit-spring data/logs/shock-cord.csv.gz -o runs/spring-a\n"
                    "  simgap fit-spring data/logs/shock-cord.csv.gz -o runs/spring-b\n"
                    "  simgap compare runs/spring-a runs/spring-b -o runs/springs",
                    define};

}  // namespace simgap::commands::compare
