#include "cli/drive_command.h"
#include "cli/inputs.h"
#include "simgap/cli/command.h"
#include "simgap/fit/actuators/fitted_drive.h"

namespace simgap::commands::fit_gearbox {
namespace {

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  struct Options : DriveCommandOptions {
    std::string motor;
    double ratio = 1.0;
  };
  auto options = std::make_shared<Options>();
  app.add_option("--motor", options->motor, "the motor's fitted model (YAML of fit-motor)")->required();
  app.add_option("--ratio", options->ratio, "motor turns per turn of the output")->required()->check(positiveNumber());
  options->add(app);
  return [options, argv] {
    Session session("fit-gearbox", options->common, argv);
    DriveFitOptions drive;
    drive.fit_motor = false;
    drive.fit_gearbox = true;
    const FittedModel motor = readModel(session, "motor", options->motor, {"motor"});
    drive.motor = motorFrom(motor);
    drive.motor_covariance = motorCovarianceFrom(motor);
    drive.ratio = options->ratio;
    return runDriveFit("gearbox", *options, session, drive);
  };
}

}  // namespace

extern const Command entry;
const Command entry{"fit-gearbox", "efficiency, friction and inertia of a gearbox behind a known motor",
                    "  simgap fit-motor data/logs/motor.csv.gz -o runs/motor\n"
                    "  simgap fit-gearbox data/logs/gearbox.csv.gz \\\n"
                    "    --motor runs/motor/model.yaml --ratio 72 -o runs/gearbox",
                    define};

}  // namespace simgap::commands::fit_gearbox
