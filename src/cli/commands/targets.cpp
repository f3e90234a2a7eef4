#include <fmt/format.h>

#include "simgap/cli/command.h"
#include "simgap/cli/session.h"
#include "simgap/report/capture/capture_rig_report.h"

namespace simgap::commands::targets {
namespace {

struct Options {
  CommonOptions common;
  std::string action;
  std::filesystem::path targets;
  double noise_mm = 0.2;
};

ExitCode run(const Options& options, const std::vector<std::string>& argv) {
  Session session("targets", options.common, argv);
  const TargetSet targets =
      readTargets(YamlNode::parse(session.read("targets", options.targets).content, options.targets.string()));
  const TargetSetReport report = checkTargets(targets, 1e-3 * options.noise_mm);
  if (options.common.dry_run) {
    session.print(fmt::format("{}nothing was written\n", terminalTable(report)));
  } else {
    session.begin(options.common.seed.value_or(0));
    session.finish(toJson(report), terminalTable(report));
  }
  return report.sound() ? ExitCode::kDone : ExitCode::kCriterionFailed;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("ACTION", options->action, "check")->required()->check(CLI::IsMember({"check"}));
  app.add_option("TARGETS", options->targets, "marker targets (YAML)")->required();
  app.add_option("--noise", options->noise_mm, "standard deviation of a triangulated marker [mm]")
      ->check(positiveNumber());
  options->common.add(app);
  return [options, argv] { return run(*options, argv); };
}

}  // namespace

extern const Command entry;
const Command entry{"targets", "check that marker targets cannot be confused (exit 1 when they can)",
                    "  simgap targets check data/capture/targets.yaml --noise 0.2", define};

}  // namespace simgap::commands::targets
