#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include "cli/fit_options.h"
#include "cli/inputs.h"
#include "cli/robot_inputs.h"
#include "simgap/cli/command.h"
#include "simgap/core/units.h"
#include "simgap/fit/actuators/fitted_drive.h"
#include "simgap/fit/actuators/free_run.h"
#include "simgap/report/actuators/prediction_report.h"
#include "simgap/report/actuators/robot_prediction_report.h"
#include "simgap/report/actuators/stretch_report.h"

namespace simgap::commands::predict {
namespace {

struct Options {
  CommonOptions common;
  LogFileOptions table;
  std::string model, log, motor, bench, gains;
  bool inverse = false, simulate = false, joint_angle = false;
  std::optional<double> ratio;
};

/// A log and the rig that it was recorded on; without --ratio the model's.
struct LogOnRig {
  CsvTable table;
  Bench bench;
};

LogOnRig readLogOnRig(const FittedModel& model, const Options& options, Session& session) {
  LogTable rows = readLog(session, "log", options.log, options.table);
  for (const std::string& sentence : rows.summary()) spdlog::warn("{}", sentence);
  const std::optional<double> ratio = options.ratio ? options.ratio : parseNumber(model.setting("transmission_ratio"));
  return {std::move(rows.table), readRig(session, options.bench, ratio)};
}

Prediction predictWith(const FittedModel& model, const Options& options, Session& session) {
  if (options.simulate && options.inverse) throw ConfigError("found --simulate and --inverse, expected one of them");
  const LogOnRig log = readLogOnRig(model, options, session);
  PredictionOptions prediction{options.inverse, {}, options.model};
  if (!options.motor.empty()) prediction.motor = readModel(session, "motor", options.motor, {"motor"});
  return options.simulate ? runFreely(model, log.table, log.bench)
                          : predictLog(model, log.table, log.bench, prediction);
}

/// Whether a plan was all that was asked for, and is said.
bool isPlanned(const Options& options, std::size_t rows, Session& session) {
  if (!options.common.dry_run) return false;
  session.print(fmt::format("would predict {} rows of {}; nothing was written\n", rows, options.log));
  return true;
}

/// Begins the result with what was asked for and what was predicted. \returns the file of the latter
std::string beginResult(const Options& options, const std::string& prediction, Session& session, const CLI::App& app) {
  session.begin(options.common.seed.value_or(0));
  session.directory().write("config.resolved.yaml", resolvedOptions(app));
  session.directory().write("prediction.csv", prediction);
  return session.directory().file("prediction.csv").string();
}

/// All joints of a robot at once.
ExitCode runRobot(const RobotModel& model, const Options& options, Session& session, const CLI::App& app) {
  if (options.inverse || options.joint_angle || options.ratio || !options.motor.empty() || !options.bench.empty()) {
    throw ConfigError(options.model +
                      ": found a robot, expected no --inverse, --joint-angle, --ratio, --motor or --bench");
  }
  if (!options.gains.empty() && !options.simulate) throw ConfigError("found --gains, expected --simulate with them");
  std::vector<JointGains> gains;
  if (!options.gains.empty()) {
    gains = readJointGains(YamlNode::parse(session.read("gains", options.gains).content, options.gains), model);
  }
  RobotLog log = readRobotLogs(session, loggedJoints(model), {options.log}, options.table);
  if (isPlanned(options, log.rows(), session)) return ExitCode::kDone;
  const auto finish = [&](const auto& prediction) {
    const std::string file = beginResult(options, predictionCsv(prediction), session, app);
    session.finish(toJson(prediction), terminalTable(prediction, file));
    return ExitCode::kDone;
  };
  if (!options.simulate) return finish(predictRobot(model, std::move(log)));
  requireSameEffort(model, log);
  RobotFreeRun run = runFreely(model, log, gains);
  return finish(RobotMotionPrediction{std::move(log), std::move(run), !gains.empty()});
}

/// The joint's angle from the motor's.
ExitCode runJointAngle(const FittedModel& model, const Options& options, Session& session, const CLI::App& app) {
  if (options.simulate || options.inverse || !options.motor.empty()) {
    throw ConfigError("found --joint-angle with --simulate, --inverse or --motor, expected one of them");
  }
  const LogOnRig log = readLogOnRig(model, options, session);
  const JointStretch stretch = predictJointAngle(model, log.table, log.bench);
  if (isPlanned(options, stretch.angle.predicted.size(), session)) return ExitCode::kDone;
  beginResult(options, predictionCsv(stretch.angle), session, app);
  if (!stretch.cells.empty()) session.directory().write("stretch.csv", stretchCsv(stretch));
  const Json result = toJson(stretch, model.kind);
  session.finish(result, answerText(stretchAnswer(result), {stretchTable(result)}));
  return ExitCode::kDone;
}

std::string ofKind(const Options& options, const FittedModel& model, const char* expected) {
  return fmt::format("with the {} model {}, expected it with {}", model.kind, options.model, expected);
}

ExitCode run(const Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("predict", options.common, argv);
  if (const auto robot = findRobotModel(session, options.model)) return runRobot(*robot, options, session, app);
  FittedModel model = readFittedModel(YamlNode::parse(session.input("model").content, options.model));
  model.file = options.model;
  if (!options.gains.empty()) throw ConfigError("found --gains with one actuator, expected a robot");
  if (model.kind != "gearbox") refuseOptions(app, {"--motor"}, ofKind(options, model, "a gearbox"));
  if (model.kind != "friction")
    refuseOptions(app, {"--bench", "--ratio"}, ofKind(options, model, "a drive's friction"));
  if (options.joint_angle) return runJointAngle(model, options, session, app);
  const Prediction prediction = predictWith(model, options, session);
  if (isPlanned(options, prediction.predicted.size(), session)) return ExitCode::kDone;
  const std::string file = beginResult(options, predictionCsv(prediction), session, app);
  session.finish(toJson(prediction, model.kind), terminalTable(prediction, file));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("MODEL", options->model,
                 "fitted model (YAML of a fit-* command), or a robot (YAML of fit-dynamics, arm, MJCF, URDF, SDF)")
      ->required();
  app.add_option("LOG,--log", options->log, "what to predict for (CSV)")->required();
  app.add_option("--motor", options->motor, "the motor's model, for a gearbox");
  app.add_option("--bench", options->bench, "the rig: where the load comes from (YAML)");
  app.add_option("--ratio", options->ratio, "motor turns per joint turn, to read joint channels")
      ->check(positiveNumber());
  app.add_flag("--inverse", options->inverse, "a muscle's pressure from force instead; a drive's current");
  app.add_flag("--simulate", options->simulate, "the motion from the effort, told only where it begins");
  app.add_option("--gains", options->gains, "of a robot's joint controllers, with --simulate (YAML)");
  app.add_flag("--joint-angle", options->joint_angle,
               "the joint's angle from the motor's, by the stretch of the cable");
  options->table.add(app);
  options->common.add(app);
  return [options, argv, &app] { return run(*options, argv, app); };
}

}  // namespace

extern const Command entry;
const Command entry{"predict", "feed-forward current, force or pressure from a fitted model",
                    "  simgap fit-friction data/logs/bend-friction.csv.gz -o runs/friction\n"
                    "  simgap predict runs/friction/model.yaml data/logs/none.csv.gz \\\n"
                    "    -o runs/prediction",
                    define};

}  // namespace simgap::commands::predict
