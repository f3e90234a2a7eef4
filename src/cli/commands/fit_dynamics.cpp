#include <fmt/format.h>

#include "cli/fit_options.h"
#include "cli/robot_inputs.h"
#include "simgap/cli/command.h"
#include "simgap/core/error.h"
#include "simgap/core/yaml.h"
#include "simgap/report/actuators/dynamics_report.h"

namespace simgap::commands::fit_dynamics {
namespace {

struct Options {
  CommonOptions common;
  LogFileOptions table;
  std::string robot, gravity, payload;
  std::vector<std::string> logs, loaded;
  std::vector<double> torque_constants;
  RobotFitOptions fit;
};

/// "BODY,MASS,X,Y,Z". \param log  whose sessions from `unloaded` files on, as joinedLogs names them, carry it
KnownPayload readPayload(const std::string& text, const RobotLog& log, std::size_t unloaded) {
  const auto wrong = [&] {
    throw ConfigError(
        fmt::format("--payload: found '{}', expected BODY,MASS,X,Y,Z: a body, what it carries [kg] and "
                    "where its centre is in the body's frame [m]",
                    text));
  };
  const std::size_t end = text.find(',');
  if (end == std::string::npos) wrong();
  KnownPayload payload;
  payload.body = text.substr(0, end);
  std::vector<double> numbers;
  for (const YamlNode& node :
       YamlNode::parse("payload: [" + text.substr(end + 1) + "]", "--payload").at("payload").items()) {
    numbers.push_back(node.number());
  }
  if (numbers.size() != 4 || !(numbers[0] > 0.0)) wrong();
  payload.mass = numbers[0];
  payload.centre = {numbers[1], numbers[2], numbers[3]};
  for (const std::string& name : log.session_names) {
    payload.carried.push_back(static_cast<std::size_t>(std::stoul(name)) > unloaded);
  }
  return payload;
}

ExitCode run(Options options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("fit-dynamics", options.common, argv);
  DynamicsReport report;
  report.file = readRobotFile(session, options.robot, options.gravity);
  if (options.loaded.empty() != options.payload.empty()) {
    throw ConfigError(options.payload.empty()
                          ? "found --loaded-log without --payload, expected what those logs carry"
                          : "found --payload without --loaded-log, expected the logs that carry it");
  }
  std::vector<std::string> logs = options.logs;
  logs.insert(logs.end(), options.loaded.begin(), options.loaded.end());
  report.log = readRobotLogs(session, loggedJoints(report.file), logs, options.table);
  if (!options.payload.empty()) options.fit.payload = readPayload(options.payload, report.log, options.logs.size());
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
  app.add_option("--law", options->fit.law, "law of friction of every joint (load-coulomb: by what it carries, too)")
      ->default_val("coulomb");
  app.add_option("--torque-constants", options->torque_constants,
                 "torque per current at each joint, in the robot's order (comma-separated) [Nm/A]; for a log of "
                 "currents")
      ->delimiter(',')
      ->check(positiveNumber());
  app.add_option(
      "--loaded-log", options->loaded,
      "log with the --payload on the robot; several. Currents with and without it tell the torque constants");
  app.add_option("--payload", options->payload,
                 "BODY,MASS,X,Y,Z: what a body carries in each --loaded-log, a mass [kg] with its centre in the body's "
                 "frame [m]");
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
