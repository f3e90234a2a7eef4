#include <fmt/format.h>
#include <malloc.h>
#include <spdlog/spdlog.h>

#include <optional>
#include <span>

#include "cli/fit_options.h"
#include "cli/inputs.h"
#include "cli/motion_commands.h"
#include "cli/robot_diagnose.h"
#include "simgap/cli/command.h"
#include "simgap/core/progress.h"
#include "simgap/core/run_directory.h"
#include "simgap/core/units.h"
#include "simgap/fit/actuators/holdout.h"
#include "simgap/measure/logs/joined_logs.h"
#include "simgap/report/diagnosis/candidate_files.h"
#include "simgap/report/diagnosis/diagnosis_report.h"
#include "simgap/simulate/arm_geometry.h"
#include "simgap/simulate/replay.h"

namespace simgap::commands::diagnose {
namespace {

struct Options {
  CommonOptions common;
  LogFileOptions table;
  std::string model, bench, config, motions, validation_motions;
  std::vector<std::string> logs, poses;
  std::optional<double> ratio;
  std::optional<int> max_causes;
  std::string holdout;
  std::vector<double> torque_constants;
  LogDiagnosisOptions diagnose;
};

/// Every refit takes arrays as long as the log; unless told otherwise glibc asks the system for each of them, and a
/// third of the time goes into that.
void keepMemory() {
#ifdef __GLIBC__
  mallopt(M_MMAP_THRESHOLD, 1 << 28);
  mallopt(M_TRIM_THRESHOLD, 1 << 30);
#endif
}

std::vector<std::string> contentsOf(std::span<const Input> inputs, std::string_view role) {
  std::vector<std::string> contents;
  for (const Input& input : inputs) {
    if (input.role == role) contents.push_back(input.content);
  }
  return contents;
}

/// What both kinds of data end with.
void finish(const Diagnosis& diagnosis, Session& session) {
  for (const std::string& warning : diagnosis.warnings) spdlog::warn("{}", warning);
  session.finish(toJson(diagnosis), terminalTable(diagnosis));
}

ExitCode runLog(const Options& options, Session& session, const CLI::App& app) {
  keepMemory();
  FittedModel given;
  const ActuatorModel subject = readSubject(session, options.model, given);
  const Bench bench = readRig(session, options.bench, options.ratio);
  std::vector<LogTable> files;
  for (const std::string& file : options.logs) files.push_back(readLog(session, "log", file, options.table));
  LogTable file_rows = joinedLogs(std::move(files));
  const CsvTable& table = file_rows.table;
  PreparedLog log = prepareLog(table, bench, subject.base.kind);
  log.left_out = std::move(file_rows.left_out);
  LogDiagnosisOptions diagnose = options.diagnose;
  if (options.max_causes) diagnose.max_causes = *options.max_causes;
  const Holdout holdout = readHoldout(options.holdout, table);
  if (holdout.fraction) diagnose.holdout = *holdout.fraction;
  diagnose.heldout_rows = holdout.rows;
  requireDiagnosable(log, diagnose);
  if (options.common.dry_run) {
    session.print(fmt::format("would diagnose {} on {} rows of {}; nothing was written\n", subject.base.name(),
                              table.rows(), table.name()));
    return ExitCode::kDone;
  }
  session.begin(diagnose.seed);
  session.directory().write("config.resolved.yaml", resolvedOptions(app));
  std::optional<Progress> progress(std::in_place, "diagnose:", 100, options.common.quiet, Progress::Unit::kPercent);
  const LogDiagnosis result = diagnoseLog(subject, log, diagnose, [&](const std::string& what, double done) {
    progress->update(static_cast<std::size_t>(100.0 * done), what);
  });
  const Input& file = session.input("log");
  const bool joined = options.logs.size() > 1, kept = result.candidates.size() > 1;
  const std::string csv = joined || kept ? logCsv(table) : "";
  LogSource source{file.file.filename().string(), file.sha256, result.diagnosis.samples};
  if (joined) source = {table.name(), sha256(csv), source.rows};
  writeLogDiagnosis(result, given, subject, log, source, session.directory());
  if (kept) {
    writeLogCandidates(result, given, subject, log, source, csv,
                       options.bench.empty() ? "" : session.input("bench").content, options.ratio, session.directory());
  }
  progress.reset();  // the result stands below its line
  finish(result.diagnosis, session);
  return ExitCode::kDone;
}

PoseDiagnosisOptions poseOptions(const Options& options) {
  PoseDiagnosisOptions pose;
  static_cast<DiagnosisOptions&>(pose) = options.diagnose;
  if (options.max_causes) pose.max_causes = static_cast<std::size_t>(*options.max_causes);
  pose.self_test = options.diagnose.self_tests;
  if (!options.holdout.empty()) {
    const auto fraction = parseNumber(options.holdout);
    if (!fraction) {
      throw ConfigError(fmt::format("--holdout: found '{}', expected a fraction of the poses", options.holdout));
    }
    pose.holdout = *fraction;
  }
  pose.validate();
  return pose;
}

ExitCode runPoses(const Options& options, Session& session) {
  const PoseDiagnosisOptions diagnose = poseOptions(options);
  const ArmModel model = readArmFile(session, "model", options.model);
  const PoseSet set = readPoses(session, "poses", options.poses, model, options.table.csv());
  requireEnough(set, diagnose);
  const CalibrationConfig config = readConfig(session, options.config, &model);
  if (options.common.dry_run) {
    session.print(fmt::format("would diagnose {} on {} poses of {}; nothing was written\n", model.name,
                              set.poses.size(), set.file));
    return ExitCode::kDone;
  }
  session.begin(diagnose.seed);
  session.directory().write("config.resolved.yaml", config.toYaml());
  std::optional<Progress> progress(std::in_place, "diagnose:", 100, options.common.quiet, Progress::Unit::kPercent);
  const PoseDiagnosis result = diagnosePoses(
      model, set, config.parameters, config.noise, diagnose,
      [&](const std::string& what, double done) { progress->update(static_cast<std::size_t>(100.0 * done), what); });
  writePoseDiagnosis(result, session.directory());
  writeCandidates(result, model, contentsOf(session.inputs(), "poses"), session.directory());
  const std::unique_ptr<Evaluator> evaluator = makeEvaluator("equilibrium", {});
  const Assessment before = replayAll(*evaluator, model, set), after = replayAll(*evaluator, result.model, set);
  const ReplayedSet replays[] = {{"all", "given", model, set, before.outcomes},
                                 {"all", "with the causes", result.model, set, after.outcomes}};
  writeArmGeometry(replays, session.directory());
  progress.reset();  // the result stands below its line
  finish(result.diagnosis, session);
  return ExitCode::kDone;
}

ExitCode runMotions(const Options& options, Session& session) {
  MotionDiagnoseOptions motion{options.common,
                               options.table.skip_bad_rows,
                               options.model,
                               options.motions,
                               options.validation_motions,
                               options.config,
                               {}};
  if (options.diagnose.self_tests > 0)
    throw ConfigError("found --self-test with --motions, expected it with --log or --poses");
  static_cast<DiagnosisOptions&>(motion.diagnose) = options.diagnose;
  if (options.max_causes) motion.diagnose.max_causes = static_cast<std::size_t>(*options.max_causes);
  if (!options.holdout.empty()) {
    const auto fraction = parseNumber(options.holdout);
    if (!fraction || !options.validation_motions.empty()) {
      throw ConfigError(
          fmt::format("--holdout: found '{}', expected a fraction of the motions, without "
                      "--validation-motions",
                      options.holdout));
    }
    motion.diagnose.holdout = *fraction;
  }
  return diagnoseMotionSet(motion, session);
}

ExitCode runRobot(const Options& options, Session& session, const CLI::App& app) {
  if (!options.bench.empty() || options.ratio || options.diagnose.self_tests > 0) {
    throw ConfigError(options.model + ": found a robot, expected no --bench, --ratio or --self-test");
  }
  RobotDiagnoseOptions robot{options.common, options.table, options.model, options.logs, options.torque_constants, {}};
  static_cast<DiagnosisOptions&>(robot.diagnose) = options.diagnose;
  if (options.max_causes) robot.diagnose.max_causes = *options.max_causes;
  if (!options.holdout.empty()) {
    const auto fraction = parseNumber(options.holdout);
    if (!fraction || !(*fraction > 0.0 && *fraction <= 0.5)) {
      throw ConfigError(
          fmt::format("--holdout: found '{}', expected a fraction of a robot's blocks in (0, 0.5]", options.holdout));
    }
    robot.diagnose.holdout = *fraction;
  }
  return diagnoseRobotLog(robot, session, app);
}

ExitCode run(const Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("diagnose", options.common, argv);
  if (int{!options.logs.empty()} + int{!options.poses.empty()} + int{!options.motions.empty()} != 1) {
    throw ConfigError("found none or several of --log, --poses and --motions, expected one of them");
  }
  if (options.logs.empty() && !options.table.topics.empty()) {
    throw ConfigError("found --topic without --log, expected it with --log");
  }
  if (options.motions.empty() && !options.validation_motions.empty()) {
    throw ConfigError("found --validation-motions without --motions, expected both");
  }
  if (options.logs.empty()) {
    refuseOptions(app, {"--bench", "--ratio", "--torque-constants"}, "without --log, expected it with --log");
  } else {
    refuseOptions(app, {"--config"}, "with --log, expected it with --poses or --motions");
  }
  if (!options.motions.empty()) refuseOptions(app, {"--map"}, "with --motions, expected it with --log or --poses");
  if (!options.motions.empty()) return runMotions(options, session);
  if (!options.logs.empty() && namesRobot(session, options.model)) {
    Session robot("diagnose", options.common, argv);  // whose inputs are read once
    return runRobot(options, robot, app);
  }
  if (!options.torque_constants.empty()) {
    throw ConfigError("found --torque-constants, expected them with a robot and --log only");
  }
  return options.poses.empty() ? runLog(options, session, app) : runPoses(options, session);
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option(
         "MODEL", options->model,
         "fitted model of a drive, motor, gearbox, muscle or spring, or arm model (YAML); or a name: a friction law "
         "(classic, variant-a, …), motor, gearbox, pam or spring; with the log of all joints a robot: what "
         "fit-dynamics has found, or URDF, MJCF, SDF")
      ->required();
  app.add_option("--log", options->logs,
                 "measured log (CSV) of a drive, muscle, spring or robot; several: sessions of one rig");
  app.add_option("--poses", options->poses, "recorded poses (CSV) of an arm; several files: of one and the same arm");
  app.add_option("--motions", options->motions, "recorded motions (YAML) of an arm");
  app.add_option("--validation-motions", options->validation_motions,
                 "other motions that only measure the gain (default: 30 % of --motions)");
  app.add_option("--config", options->config,
                 "of --poses and --motions: calibration config with parameters and priors (default: built in)");
  app.add_option("--bench", options->bench, "the rig: where the load comes from (YAML; default: external_torque_Nm)");
  app.add_option("--ratio", options->ratio, "motor turns per joint turn, to read joint channels")
      ->check(positiveNumber());
  app.add_option("--torque-constants", options->torque_constants,
                 "of a robot whose file has none and a log of currents: torque per current at each joint "
                 "(comma-separated) [Nm/A]")
      ->delimiter(',')
      ->check(positiveNumber());
  app.add_option(
      "--holdout", options->holdout,
      "what only measures the gain: a fraction of the blocks or poses (default 0.25), or COLUMN=VALUE,… of a log");
  app.add_option("--effects", options->diagnose.effects, "try these causes only (comma-separated)")->delimiter(',');
  app.add_option("--max-causes", options->max_causes, "stop after so many causes (default 4, of poses 8, of motions 2)")
      ->check(CLI::Range(1, 10));
  app.add_option("--level", options->diagnose.level, "false-alarm rate of each step")->check(CLI::Range(1e-6, 0.5));
  app.add_option("--self-test", options->diagnose.self_tests,
                 "hide every effect, and none, N times in this very log and count what is named")
      ->check(CLI::Range(1, 1000));
  app.add_flag("--ignore-faults", options->diagnose.ignore_faults, "go on where the data look wrong");
  options->table.add(app);
  options->common.add(app);
  return [options, argv, &app] {
    options->diagnose.seed = options->common.seed.value_or(options->diagnose.seed);
    return run(*options, argv, app);
  };
}

}  // namespace

extern const Command entry;
const Command entry{"diagnose", "what the model gets wrong, the physical cause, and the gain on data never used",
                    "  simgap diagnose classic --log data/logs/bend-friction.csv.gz \\\n"
                    "    -o runs/diagnosis\n"
                    "  simgap diagnose data/robot/robot.urdf --log data/robot/log.csv.gz \\\n"
                    "    -o runs/diagnosis-robot\n"
                    "  simgap diagnose data/arm-dense/arm.yaml \\\n"
                    "    --poses data/arm-dense/poses_calibration.csv -o runs/diagnosis-arm\n"
                    "  simgap diagnose data/motions/arm.yaml --dry-run \\\n"
                    "    --motions data/motions/open-none/calibration/motions.yaml \\\n"
                    "    --validation-motions data/motions/open-none/validation/motions.yaml",
                    define};

}  // namespace simgap::commands::diagnose
