#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "cli/bench_protocol.h"
#include "cli/excitation.h"
#include "cli/inputs.h"
#include "cli/separation.h"
#include "simgap/cli/command.h"
#include "simgap/core/error.h"
#include "simgap/report/poses/design_report.h"

namespace simgap::commands::design {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  std::string model, poses, config, criterion = "prediction";
  std::size_t candidates = 300, count = 7;
  SeparateOptions separate;
  ExciteOptions excite;
  DriveDesignOptions drive;
};

ExitCode nextPoses(const Options& options, const std::vector<std::string>& argv) {
  if (options.model.empty() || options.poses.empty()) {
    throw ConfigError(
        "found no MODEL or no --poses, expected both, or --separate RUN, --excite ROBOT LIMITS or --drive LIMITS");
  }
  if (options.count > options.candidates) {
    throw ConfigError(fmt::format("found --count {} of --candidates {}, expected at least as many", options.count,
                                  options.candidates));
  }
  Session session("design", options.common, argv);
  const ArmModel model = readArmFile(session, "model", options.model);
  const CalibrationConfig config = readConfig(session, options.config, &model);
  const PoseSet recorded = readPoses(session, "poses", options.poses, model, options.table.csv());
  requireDesignable(recorded);
  DesignOptions design{options.candidates, options.count};
  design.seed = options.common.seed.value_or(config.strategy.seed);
  if (options.criterion == "information") design.criterion = DesignCriterion::kInformation;
  if (options.common.dry_run) {
    session.print(fmt::format("would fit {} parameters to {} poses and choose {} of {} commands; nothing was written\n",
                              ParameterSpace(model, config.parameters).size(), recorded.poses.size(), design.poses,
                              design.candidates));
    return ExitCode::kDone;
  }
  session.begin(design.seed);
  session.directory().write("config.resolved.yaml", config.toYaml());
  const DesignResult result = designNextPoses(model, recorded, config, design);
  writeDesignReport(result, session.directory());
  session.finish(toJson(result), terminalTable(result));
  return ExitCode::kDone;
}

/// Options of the other ways to use the command.
void refuseForeign(const Options& options, const CLI::App& app) {
  const bool drive = !options.drive.limits.empty(), excite = !options.excite.robot.empty();
  const bool separate = !options.separate.of.run.empty();
  if (!separate) {
    refuseOptions(app, {"--speeds", "--loads", "--max-tension-N", "--max-current-A", "--max-duration-s"},
                  "without --separate, expected it with --separate RUN");
  }
  if (!excite) refuseOptions(app, {"--law", "--gravity"}, "without --excite, expected it with --excite ROBOT");
  if (!(drive || excite || separate)) return;
  const char* const way = drive ? "--drive" : excite ? "--excite" : "--separate";
  const std::string sentence = fmt::format("with {}, expected it with MODEL and --poses", way);
  refuseOptions(app, {"--config", "--criterion", "--map", "--skip-bad-rows"}, sentence);
  if (!separate) refuseOptions(app, {"--candidates", "--count"}, sentence + ", or --separate");
}

ExitCode run(Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  refuseForeign(options, app);
  if (!options.drive.limits.empty()) {
    if (!options.poses.empty() || !options.excite.robot.empty() || !options.separate.of.run.empty()) {
      throw ConfigError("found --drive LIMITS with --poses, --excite or --separate, expected LIMITS and at most MODEL");
    }
    options.drive.common = options.common;
    options.drive.model = options.model;
    return designBench(options.drive, argv);
  }
  if (!options.excite.robot.empty()) {
    if (options.model.empty() || !options.poses.empty() || !options.separate.of.run.empty()) {
      throw ConfigError(
          "found --excite ROBOT without LIMITS, or with --poses or --separate, expected ROBOT and LIMITS");
    }
    options.excite.common = options.common;
    options.excite.limits = options.model;
    return designExcitation(options.excite, argv);
  }
  if (options.separate.of.run.empty()) return nextPoses(options, argv);
  if (!options.model.empty() || !options.poses.empty()) {
    throw ConfigError("found MODEL or --poses with --separate, expected the result of simgap diagnose alone");
  }
  options.separate.of.common = options.common;
  options.separate.candidates = options.candidates;
  options.separate.count = options.count;
  return designSeparation(options.separate, argv, app);
}

void addLimits(CLI::App& app, MotionLimits& limits) {
  app.add_option("--max-tension-N", limits.tension, "of --separate with poses or motions: no muscle is pulled harder")
      ->check(positiveNumber());
  app.add_option("--max-current-A", limits.current, "of --separate with a log or motions: no motor draws more")
      ->check(positiveNumber());
  app.add_option("--max-duration-s", limits.duration, "of --separate with a log or motions: nothing lasts longer")
      ->check(positiveNumber());
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("MODEL", options->model,
                 "arm model as measured by hand (YAML); with --excite: LIMITS (YAML); with --drive: a fitted drive");
  app.add_option("--poses", options->poses, "poses recorded so far, 8 or more (CSV)");
  app.add_option("--config", options->config, "parameters and their priors (YAML; default: the paper's)");
  app.add_option("--candidates", options->candidates, "commands to choose from")->check(CLI::Range(1, 100000));
  app.add_option("--count", options->count, "poses to choose, or motions at most")->check(CLI::Range(1, 1000));
  app.add_option("--criterion", options->criterion, "prediction: I-optimal; information: D-optimal")
      ->check(CLI::IsMember({"prediction", "information"}));
  SeparateOptions& separate = options->separate;
  app.add_option("--separate", separate.of.run, "instead: what tells the models of this diagnosis apart (directory)");
  app.add_option("--speeds", separate.speeds,
                 "of --separate with a log or motions: how many times as fast (default 0.5,1,2)")
      ->delimiter(',')
      ->check(positiveNumber());
  app.add_option("--loads", separate.loads, "of --separate with a log: under how many times the load (default 0.5,1,2)")
      ->delimiter(',')
      ->check(finiteNumber());
  addLimits(app, separate.limits);
  ExciteOptions& excite = options->excite;
  app.add_option("--excite", excite.robot,
                 "instead: the motion that tells a robot's bodies and drives best (arm, URDF, MJCF or SDF)");
  app.add_option("--law", excite.law, "of --excite: friction of every joint, coulomb or stribeck")
      ->default_val("coulomb");
  app.add_option("--gravity", excite.gravity, "of --excite: X,Y,Z in the robot's base, instead of its file's [m/s^2]");
  app.add_option("--drive", options->drive.limits,
                 "instead: the log to record of one drive, within these limits (YAML)");
  options->table.add(app);
  options->common.add(app);
  return [options, argv, &app] { return run(*options, argv, app); };
}

}  // namespace

extern const Command entry;
const Command entry{"design", "which poses to record next",
                    "  simgap design data/arm/arm.yaml \\\n"
                    "    --poses data/arm/poses_calibration.csv --count 5 -o runs/design\n"
                    "  simgap diagnose data/arm-dense/arm.yaml \\\n"
                    "    --poses data/arm-dense/poses_calibration.csv -o runs/diagnosis-arm\n"
                    "  simgap design --separate runs/diagnosis-arm --count 2 -o runs/next\n"
                    "  simgap design --excite data/robot/robot.urdf \\\n"
                    "    data/robot/limits.yaml -o runs/excitation\n"
                    "  simgap design --drive data/logs/drive-limits.yaml -o runs/protocol",
                    define};

}  // namespace simgap::commands::design
