#include <fmt/format.h>

#include "cli/fit_options.h"
#include "cli/robot_inputs.h"
#include "simgap/cli/command.h"
#include "simgap/report/actuators/dynamics_report.h"

namespace simgap::commands::fit_dynamics {
namespace {

struct Options {
  CommonOptions common;
  LogFileOptions table;
  std::string robot, gravity;
  std::vector<std::string> logs;
  std::vector<double> torque_constants;
  RobotFitOptions fit;
};

ExitCode run(Options options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("fit-dynamics", options.common, argv);
  DynamicsReport report;
  report.file = readRobotFile(session, options.robot, options.gravity);
  report.log = readRobotLogs(session, loggedJoints(report.file), options.logs, options.table);
  if (!options.torque_constants.empty()) options.fit.torque_constants = options.torque_constants;
  if (options.common.dry_run) {
    session.print(fmt::format("would fit {} joints to {} rows of {}; nothing was written\n", report.log.joints.size(),
                              report.log.rows(), report.log.file));
    return ExitCode::kDone;
  }
  report.found = fitRobot(report.file, report.log, options.fit);
  report.found.model.data_file = report.log.file;
  report.found.model.data_sha256 = session.input("log").sha256;
  session.begin(options.common.seed.value_or(0));
  session.directory().write("config.resolved.yaml", resolvedOptions(app));
  writeDynamicsReport(report, session.directory());
  session.finish(toJson(report), terminalTable(report));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("ROBOT", options->robot, "the robot: arm (YAML), MJCF, URDF or SDF; its muscles are left aside")
      ->required();
  app.add_option("--log", options->logs,
                 "log of all joints (CSV: time_s; of each joint J its J_rad, torque_J_Nm or current_J_A, and "
                 "J_velocity_rad_s where it was measured); several: trajectories of one robot")
      ->required();
  app.add_option("--law", options->fit.law, "friction of every joint: coulomb or stribeck")->default_val("coulomb");
  app.add_option("--torque-constants", options->torque_constants,
                 "torque per current at each joint, in the robot's order (comma-separated) [Nm/A]; for a log of "
                 "currents")
      ->delimiter(',')
      ->check(CLI::PositiveNumber & finiteNumber());
  app.add_option("--gravity", options->gravity, "X,Y,Z: gravity in the robot's base, instead of its file's [m/s^2]");
  options->table.add(app);
  options->common.add(app);
  return [options, argv, &app] { return run(*options, argv, app); };
}

}  // namespace

extern const Command entry;
const Command entry{"fit-dynamics", "bodies and drives of a robot from a log of all its joints",
                    "  simgap fit-dynamics data/robot/robot.urdf \\\n"
                    "    --log data/robot/log.csv.gz -o runs/dynamics",
                    define};

}  // namespace simgap::commands::fit_dynamics
