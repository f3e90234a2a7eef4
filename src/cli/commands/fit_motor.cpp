#include "../drive_command.h"
#include "simgap/cli/command.h"

namespace simgap::commands {
namespace {

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<DriveCommandOptions>();
  options->add(app);
  return [options, argv] {
    Session session("fit-motor", options->common, argv);
    return runDriveFit("motor", *options, session, {});
  };
}

}  // namespace

extern const Command fit_motor;
const Command fit_motor{"fit-motor", "constants of a DC motor from its log, by the simulated response",
                        "  simgap fit-motor motor.csv --into arm.yaml --muscle biceps -o runs/motor", define};

}  // namespace simgap::commands
