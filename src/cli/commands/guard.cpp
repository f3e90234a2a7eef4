#include <fmt/format.h>

#include "simgap/cli/command.h"
#include "simgap/cli/session.h"
#include "simgap/report/runs/budget.h"

namespace simgap::commands::guard {
namespace {

struct Options {
  CommonOptions common;
  std::filesystem::path budget, run;
};

ExitCode run(const Options& options, const std::vector<std::string>& argv) {
  Session session("guard", options.common, argv);
  const Budget budget =
      readBudget(YamlNode::parse(session.read("budget", options.budget).content, options.budget.string()));
  const ResultFiles files(options.run);
  session.read("run", options.run / "result.json");
  const Json guard = checkBudget(budget, files);
  if (options.common.dry_run) {
    session.print(
        fmt::format("would check {} limits of {}; nothing was written\n", budget.limits.size(), options.run.string()));
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  session.directory().write("guard.xml", guardJunit(guard));
  session.directory().write("guard.md", guardMarkdown(guard));
  session.finish(guard, guardText(guard));
  return holds(guard) ? ExitCode::kDone : ExitCode::kCriterionFailed;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("BUDGET", options->budget, "limits on errors, parameters, causes (YAML)")->required();
  app.add_option("RUN", options->run, "result directory of a run")->required();
  options->common.add(app);
  return [options, argv] { return run(*options, argv); };
}

}  // namespace

extern const Command entry;
const Command entry{"guard", "hold a run against a budget (exit 1 when a limit is broken)",
                    "  simgap fit-spring data/logs/shock-cord.csv.gz -o runs/spring\n"
                    "  simgap guard configs/budget_spring.yaml runs/spring -o runs/guard",
                    define};

}  // namespace simgap::commands::guard
