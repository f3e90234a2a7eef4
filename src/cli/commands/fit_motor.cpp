#include "cli/drive_command.h"
#include "simgap/cli/command.h"

namespace simgap::commands::fit_motor {
namespace {

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  struct Options : DriveCommandOptions {
    std::string model;
  };
  auto options = std::make_shared<Options>();
  app.add_option("--model", options->model,
                 "a diagnosed motor (YAML): the constants of its winding and its extensions are fitted together");
  options->add(app);
  return [options, argv, &app] {
    Session session("fit-motor", options->common, argv);
    if (!options->model.empty()) {
      return runRefit({"fit-motor", options->model, options->log, options->table}, session, app);
    }
    return runDriveFit("motor", *options, session, {});
  };
}

}  // namespace

extern const Command entry;
const Command entry{"fit-motor", "constants of a DC motor from its log, by the simulated response",
                    "  simgap fit-motor data/logs/motor.csv.gz --into data/arm/arm.yaml \\\n"
                    "    --muscle biceps -o runs/motor",
                    define};

}  // namespace simgap::commands::fit_motor
