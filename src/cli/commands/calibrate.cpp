#include <fmt/format.h>
#include <fmt/ranges.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <set>

#include "cli/inputs.h"
#include "cli/kept_inputs.h"
#include "cli/motion_commands.h"
#include "simgap/cli/command.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/progress.h"
#include "simgap/core/ranks.h"
#include "simgap/core/rotation.h"
#include "simgap/core/text.h"
#include "simgap/fit/poses/calibration_run.h"
#include "simgap/report/poses/pose_report.h"

namespace simgap::commands::calibrate {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  std::string model, poses, validation, motions, validation_motions, config;
  std::filesystem::path resume;
  StrategyOptions strategy;
  std::optional<bool> early_acquisition;
  std::optional<std::string> evaluator, optimizer, objective, verify;
  std::optional<int> starts;
  std::optional<double> settle;  ///< [s]
  std::string only, only_poses;
};

/// An option of another optimiser would change nothing.
void refuseForeignOptions(const Options& options, const CalibrationConfig& config) {
  const std::string& chosen = config.optimizer;
  const auto refuse = [&](bool given, const char* option, std::set<std::string> optimizers) {
    if (!given || optimizers.contains(chosen)) return;
    throw ConfigError(fmt::format("found {} with --optimizer {}, expected it with --optimizer {}", option, chosen,
                                  fmt::join(optimizers, " or ")));
  };
  refuse(options.strategy.generations.has_value(), "--generations", {"es", "cma-es"});
  refuse(options.strategy.mu.has_value(), "--mu", {"es", "hybrid"});
  refuse(options.strategy.lambda.has_value(), "--lambda", {"es", "cma-es", "hybrid"});
  refuse(options.starts.has_value(), "--starts", {"lm", "hybrid"});
  refuse(options.objective.has_value(), "--objective", {"es", "cma-es"});
}

void applyOverrides(const Options& options, CalibrationConfig& config) {
  if (options.early_acquisition) config.protocol.early_acquisition = *options.early_acquisition;
  if (options.optimizer) config.optimizer = *options.optimizer;
  if (options.evaluator) config.evaluator = *options.evaluator;
  if (options.objective) {
    config.objective = options.objective == "paper" ? PoseObjective::kPaper : PoseObjective::kGeodesic;
  }
  if (options.verify) config.verify = *options.verify;
  if (options.starts) config.starts = *options.starts;
  if (!options.only_poses.empty()) config.only_poses = options.only_poses;
  if (options.settle) config.protocol.settle = *options.settle;
  for (ParameterSpace::Choice& choice : config.parameters) {
    if (!options.only.empty()) choice.only = options.only;
  }
  if (config.usesPosterior()) {
    if (options.evaluator == "bullet") {
      throw ConfigError(
          fmt::format("--optimizer {} needs derivatives, which only --evaluator equilibrium has", config.optimizer));
    }
    config.evaluator = "equilibrium";
  }
  refuseForeignOptions(options, config);
  options.strategy.applyTo(config.optimizer, options.common.seed, config.strategy);
}

CalibrationTask readTask(const Options& options, Session& session) {
  if (options.model.empty() || options.poses.empty()) {
    throw ConfigError("calibrate needs MODEL and --poses, or --resume (see simgap calibrate --help)");
  }
  const CsvOptions csv = options.table.csv();
  CalibrationTask task;
  task.model = readArmFile(session, "model", options.model);
  task.config = readConfig(session, options.config, &task.model);
  applyOverrides(options, task.config);
  task.poses = readPoses(session, "poses", options.poses, task.model, csv);
  const std::size_t read = task.poses.poses.size();
  keepPosesNamed(task.poses, task.config.only_poses);
  if (const std::size_t kept = task.poses.poses.size(); kept < read) {
    spdlog::info("{}: {} of {} poses are named '{}'", task.poses.file, kept, read, task.config.only_poses);
  }
  if (!options.validation.empty()) {
    task.validation = readPoses(session, "validation", options.validation, task.model, csv);
    requireOtherPoses(*task.validation, task.poses, "what a search has seen validates nothing");
  }
  return task;
}

/// The options with which an interrupted run goes on: the copies in its own directory.
Options resumedOptions(const Options& given) {
  Options options = given;
  KeptInputs kept = readKeptInputs(given.resume);
  options.table.map = std::move(kept.map);
  options.table.skip_bad_rows = kept.skip_bad_rows;
  options.model = std::move(kept.model);
  options.poses = std::move(kept.poses);
  options.validation = std::move(kept.validation);
  options.config = (given.resume / kKeptConfig).string();
  return options;
}

void search(Calibration& calibration, const CalibrationTask& task, const Session& session) {
  const PoseLayout layout = task.model.poseLayout();
  Progress progress(task.config.usesPosterior() ? "calibrate: descent" : "calibrate: generation",
                    expectedSteps(task.config), session.options().quiet);
  progress.startFrom(static_cast<std::size_t>(calibration.state().strategy.generation));
  searchAndStore(calibration, session.directory(), [&](const CalibrationState& state) {
    std::string detail;
    for (std::size_t j = 0; j < state.best_mje.size(); ++j) {
      const JointKind& kind = kindOf(layout.joints[j].type);
      detail +=
          fmt::format("{} {} {}  ", layout.joints[j].name, degreesCell(kind.shown(state.best_mje[j])), kind.error_unit);
    }
    progress.update(static_cast<std::size_t>(state.strategy.generation), detail);
  });
}

CalibrationResult judge(const CalibrationTask& task, const Calibration& calibration,
                        const CalibrationEvaluators& evaluators, bool quiet) {
  std::optional<Progress> progress;
  return judgeCalibration(task, calibration, evaluators, [&](std::size_t done, std::size_t total) {
    if (!progress) progress.emplace("judge: pose", total, quiet);
    progress->update(done);
    if (done == total) progress.reset();
  });
}

/// The search and the judgement of what it found.
CalibrationResult searchAndJudge(Calibration& calibration, const CalibrationTask& task,
                                 const CalibrationEvaluators& evaluators, Session& session) {
  try {
    search(calibration, task, session);
    return judge(task, calibration, evaluators, session.options().quiet);
  } catch (const NumericsError& error) {
    session.abandon(std::string("failed: ") + error.what());
    throw;
  } catch (const InterruptedError&) {
    throw InterruptedError(fmt::format("interrupted after {} generations; go on with: simgap calibrate --resume {}",
                                       calibration.state().strategy.generation,
                                       shellWord(session.directory().path().string())));
  }
}

ExitCode run(const Options& given, const std::vector<std::string>& argv) {
  const bool resuming = !given.resume.empty();
  const Options options = resuming ? resumedOptions(given) : given;
  Session session("calibrate", options.common, argv);
  const CalibrationTask task = readTask(options, session);
  if (options.common.dry_run) {
    session.print(planText(task, expectedResult(task)));
    return ExitCode::kDone;
  }
  const CalibrationEvaluators evaluators(task.config);
  Calibration calibration(task.model, task.poses.poses, task.config, *evaluators.search);
  if (resuming) {
    session.resume(options.resume, task.config.strategy.seed);
    if (restoreStored(calibration, session.directory())) {
      spdlog::info("going on after generation {}", calibration.state().strategy.generation);
    }
  } else {
    session.begin(task.config.strategy.seed);
    keepInputs(session, options.table, task.config);
  }
  const CalibrationResult result = searchAndJudge(calibration, task, evaluators, session);
  const ArmModel best = calibration.bestModel();
  for (const std::string& warning : calibrationWarnings(best, result)) spdlog::warn("{}", warning);
  writeCalibration(task.model, best, result, session.directory());
  const std::string failure = judgeDelivery(result).failure;
  session.finish(toJson(result), terminalTable(result), failure.empty() ? "done" : "failed: " + failure);
  if (!failure.empty()) throw NumericsError(failure);
  return ExitCode::kDone;
}

/// A resumed run ends bit-identically only with the options it began with.
void refuseWithResume(const CLI::App& app) {
  const std::set<std::string> allowed = {"--resume", "--threads", "--dry-run", "--json", "--quiet", "--verbose"};
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0 || allowed.contains(option->get_name(false, false))) continue;
    throw ConfigError(fmt::format("--resume goes on with the options the run began with; leave out {}",
                                  option->get_name(false, false)));
  }
}

/// With --motions, or of a directory that was begun so.
ExitCode runMotions(const Options& options, const CLI::App& app, const std::vector<std::string>& argv) {
  refuseOptions(app, {"--validation"}, "with --motions, expected --validation-motions");
  refuseOptions(app,
                {"--evaluator", "--objective", "--verify", "--starts", "--only", "--only-poses", "--settle-s", "--map",
                 "--early-acquisition"},
                "with --motions, expected it with --poses alone");
  MotionCalibrateOptions moving;
  moving.common = options.common;
  moving.skip_bad_rows = options.table.skip_bad_rows;
  moving.model = options.model;
  moving.motions = options.motions;
  moving.validation_motions = options.validation_motions;
  moving.poses = options.poses;
  moving.config = options.config;
  moving.resume = options.resume;
  moving.optimizer = options.optimizer;
  moving.strategy = options.strategy;
  return calibrateMotions(moving, argv);
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("MODEL", options->model, "arm model (YAML)");
  app.add_option("--poses", options->poses, "recorded poses the search sees (CSV)");
  app.add_option("--validation", options->validation, "recorded poses it never sees, to judge the result (CSV)");
  app.add_option("--motions", options->motions,
                 "recorded motions the search sees (YAML): static and dynamic parameters; --poses may join them");
  app.add_option("--validation-motions", options->validation_motions, "recorded motions it never sees (YAML)");
  app.add_option("--config", options->config, "what is searched and how (YAML; default: the paper's parameters)");
  app.add_option("--generations", options->strategy.generations, "of es and cma-es, instead of the config's");
  app.add_option("--mu", options->strategy.mu, "parents, of es and hybrid");
  app.add_option("--lambda", options->strategy.lambda, "offspring, of es, cma-es and hybrid");
  app.add_option("--target-fitness", options->strategy.target_fitness, "stop at this sum of squared errors [rad^2]")
      ->check(finiteNumber());
  // Not an optional<bool>: CLI11 would take it for a counter and set it to 0 when the flag is not given.
  app.add_flag_function(
      "--early-acquisition,!--no-early-acquisition",
      [options](std::int64_t count) { options->early_acquisition = count > 0; },
      "leave acquisition once all shafts have arrived; 'no' reproduces the paper's fixed times");
  app.add_option("--evaluator", options->evaluator, "bullet: simulate; equilibrium: minimise the potential energy")
      ->check(CLI::IsMember({"bullet", "equilibrium"}));
  app.add_option("--optimizer", options->optimizer,
                 "lm (default): descent with priors from several starts; es: the paper's; cma-es; hybrid: es and lm")
      ->check(CLI::IsMember({"es", "cma-es", "lm", "hybrid"}));
  app.add_option(
         "--objective", options->objective,
         "of es and cma-es: geodesic angles (default), or eq. 3 as the paper printed it (half the angle of a ball)")
      ->check(CLI::IsMember({"geodesic", "paper"}));
  app.add_option("--verify", options->verify, "who judges the model found with equilibria (default: bullet)")
      ->check(CLI::IsMember({"bullet", "none"}));
  app.add_option("--starts", options->starts, "of lm and hybrid (default: 8)")->check(CLI::Range(1, 10000));
  app.add_option("--only", options->only, "of the config's parameters those that match, 'muscles.m_*' (default: all)");
  app.add_option("--only-poses", options->only_poses, "the search sees poses of this name alone, 'right_*'");
  app.add_option("--settle-s", options->settle,
                 "longest time that joints may take to come to rest (default: the config's) [s]")
      ->check(positiveNumber());
  app.add_option("--resume", options->resume, "go on with an interrupted run in this directory; needs nothing else");
  options->table.add(app);
  options->common.add(app);
  return [options, argv, &app] {
    if (!options->resume.empty()) refuseWithResume(app);
    const bool moves = !options->motions.empty() || holdsMotionCalibration(options->resume);
    if (moves) return runMotions(*options, app, argv);
    if (!options->validation_motions.empty()) throw ConfigError("found --validation-motions without --motions");
    return run(*options, argv);
  };
}

}  // namespace

extern const Command entry;
const Command entry{"calibrate", "close the gap: search the model's parameters on recorded poses",
                    "  simgap calibrate data/arm/arm.yaml \\\n"
                    "    --poses data/arm/poses_calibration.csv \\\n"
                    "    --validation data/arm/poses_validation.csv -o runs/arm\n"
                    "  simgap calibrate --resume runs/arm\n"
                    "  simgap calibrate data/motions/arm.yaml --dry-run \\\n"
                    "    --motions data/motions/open-none/calibration/motions.yaml \\\n"
                    "    --validation-motions data/motions/open-none/validation/motions.yaml\n"
                    "  simgap calibrate data/arm/arm.yaml \\\n"
                    "    --poses data/arm/poses_calibration.csv \\\n"
                    "    --validation data/arm/poses_validation.csv \\\n"
                    "    --optimizer es --evaluator equilibrium -o runs/arm-es",
                    define};

}  // namespace simgap::commands::calibrate
