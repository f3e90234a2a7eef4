#include "cli/robot_diagnose.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>

#include "cli/robot_inputs.h"
#include "simgap/core/progress.h"
#include "simgap/report/diagnosis/diagnosis_report.h"

namespace simgap {
namespace {

/// A file that says nothing of its drives' constants has those of the command line.
void takeConstants(const RobotDiagnoseOptions& options, const RobotLog& log, RobotModel& robot) {
  if (options.torque_constants.empty()) return;
  if (robot.currents) {
    throw ConfigError(options.robot +
                      ": found a robot with torque constants and --torque-constants, expected one of them");
  }
  if (options.torque_constants.size() != log.joints.size()) {
    throw ConfigError(fmt::format("--torque-constants: found {}, expected {}: one for each joint",
                                  options.torque_constants.size(), log.joints.size()));
  }
  robot.currents = true;
  robot.torque_constants = options.torque_constants;
}

}  // namespace

bool namesRobot(Session& session, const std::string& model) {
  std::error_code none;
  return std::filesystem::is_regular_file(model, none) && findRobotModel(session, model).has_value();
}

ExitCode diagnoseRobotLog(const RobotDiagnoseOptions& options, Session& session, const CLI::App& app) {
  options.diagnose.validate();
  RobotModel robot = *findRobotModel(session, options.robot);
  RobotLog log = readRobotLogs(session, loggedJoints(robot), options.logs, options.table);
  takeConstants(options, log, robot);
  if (options.common.dry_run) {
    session.print(fmt::format("would diagnose {} joints on {} rows of {}; nothing was written\n", log.joints.size(),
                              log.rows(), log.file));
    return ExitCode::kDone;
  }
  session.begin(options.diagnose.seed);
  session.directory().write("config.resolved.yaml", resolvedOptions(app));
  std::optional<Progress> progress(std::in_place, "diagnose:", 100, options.common.quiet, Progress::Unit::kPercent);
  const RobotDiagnosis result = diagnoseRobot(robot, log, options.diagnose, [&](const std::string& what, double done) {
    progress->update(static_cast<std::size_t>(100.0 * done), what);
  });
  writeRobotDiagnosis(result, log, session.directory());
  progress.reset();  // the result stands below its line
  for (const std::string& warning : result.diagnosis.warnings) spdlog::warn("{}", warning);
  session.finish(toJson(result), terminalTable(result));
  return ExitCode::kDone;
}

}  // namespace simgap
