#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <filesystem>

#include "cli/inputs.h"
#include "cli/kept_inputs.h"
#include "cli/motion_commands.h"
#include "simgap/core/error.h"
#include "simgap/core/progress.h"
#include "simgap/core/ranks.h"
#include "simgap/core/text.h"
#include "simgap/report/motions/motion_report.h"

namespace simgap {
namespace {

constexpr const char* kKeptFile = "inputs/motions.json";
constexpr const char* kMotionState = "state.json";

MotionCalibrationConfig searchConfig(Session& session, const MotionCalibrateOptions& options, const ArmModel& model) {
  MotionCalibrationConfig config = readMotionConfig(session, options.config, model);
  if (options.optimizer) {
    if (options.optimizer == "hybrid") {
      throw ConfigError("found --optimizer hybrid with --motions, expected lm, es or cma-es");
    }
    config.optimizer = *options.optimizer;
  }
  const StrategyOptions& asked = options.strategy;
  if (config.optimizer == "lm" && (asked.generations || asked.mu || asked.lambda)) {
    throw ConfigError("found --generations, --mu or --lambda with --optimizer lm, expected them with es or cma-es");
  }
  asked.applyTo(config.optimizer, options.common.seed, config.strategy);
  return config;
}

MotionCalibrationTask readMotionTask(Session& session, const MotionCalibrateOptions& options) {
  if (options.model.empty()) throw ConfigError("calibrate needs MODEL and --motions (see simgap calibrate --help)");
  MotionCalibrationTask task;
  task.model = readArmFile(session, "model", options.model);
  task.config = searchConfig(session, options, task.model);
  const double restart = task.config.motions.motion.restart;
  task.motions = readMotions(session, "motions", options.motions, task.model, options.skip_bad_rows, restart);
  if (!options.validation_motions.empty()) {
    task.validation = readOtherMotions(session, options.validation_motions, options.motions, task.model,
                                       options.skip_bad_rows, restart);
  }
  if (!options.poses.empty()) {
    CsvOptions csv;
    csv.skip_bad_rows = options.skip_bad_rows;
    task.poses = readPoses(session, "poses", options.poses, task.model, csv);
  }
  return task;
}

std::string absoluteName(const std::filesystem::path& file) { return std::filesystem::absolute(file).string(); }

std::string sumOf(const Input& input) { return input.sha256.empty() ? sha256(input.content) : input.sha256; }

/// What --resume needs: the files where they stand, with the sums by which a change is noticed.
void keepMotionInputs(const MotionCalibrateOptions& options, const Session& session,
                      const MotionCalibrationTask& task) {
  if (!isFirstRank()) return;
  std::filesystem::create_directories(session.directory().file("inputs"));
  Json sums = Json::object();
  for (const Input& input : session.inputs()) sums[absoluteName(input.file)] = sumOf(input);
  const auto absolute = [](const std::string& file) { return file.empty() ? file : absoluteName(file); };
  session.directory().write(kKeptConfig, task.config.toYaml());
  session.directory().write(kKeptFile, Json{{"model", absolute(options.model)},
                                            {"motions", absolute(options.motions)},
                                            {"validation_motions", absolute(options.validation_motions)},
                                            {"poses", absolute(options.poses)},
                                            {"skip_bad_rows", options.skip_bad_rows},
                                            {"sha256", sums}});
}

[[noreturn]] void refuseChanged(const std::string& file) {
  throw ConfigError(fmt::format("{}: has changed since the run began, expected it as it was", file));
}

/// A directory may come from somebody else: what it names is parsed, and quoted, only when it is what the run has read.
void refuseStrangeFiles(const Json& sums, const std::vector<std::string>& files) {
  for (const std::string& file : files) {
    if (file.empty()) continue;
    const Bytes sum = shareFromFirstRank([&] { return Bytes(sha256(readFile(file))); });
    if (sums.value(absoluteName(file), "") != sum) refuseChanged(file);
  }
}

MotionCalibrateOptions resumedMotionOptions(const MotionCalibrateOptions& given) {
  MotionCalibrateOptions options = given;
  const std::filesystem::path file = given.resume / kKeptFile;
  takeKept(
      file, [&] { return readJson(file); },
      [&](const Json& kept) {
        kept.at("model").get_to(options.model);
        kept.at("motions").get_to(options.motions);
        kept.at("validation_motions").get_to(options.validation_motions);
        kept.at("poses").get_to(options.poses);
        kept.at("skip_bad_rows").get_to(options.skip_bad_rows);
        refuseStrangeFiles(kept.at("sha256"),
                           {options.model, options.motions, options.validation_motions, options.poses});
      });
  options.config = (given.resume / kKeptConfig).string();
  return options;
}

/// A run resumed with other inputs would be no continuation.
void refuseChangedInputs(const std::filesystem::path& directory, const Session& session) {
  const Json kept = Json::parse(shareFromFirstRank([&] { return toText(readJson(directory / kKeptFile)); }));
  for (const Input& input : session.inputs()) {
    const std::string file = absoluteName(input.file);
    const Json& sums = kept.at("sha256");
    if (sums.contains(file) && sums.at(file) != sumOf(input)) refuseChanged(file);
  }
}

std::string motionPlan(const MotionCalibrationTask& task, const MotionPosterior& posterior) {
  double seconds = 0.0;
  for (const RecordedMotion& motion : task.motions.motions) seconds += motion.duration();
  return fmt::format(
      "would search {} parameters on {} motions of {:.1f} s in all by {}: about {} rollouts a round, at "
      "most {} rounds\nnothing was written\n",
      posterior.size(), task.motions.motions.size(), seconds, task.config.optimizer,
      posterior.size() * std::ssize(task.motions.motions), task.config.rounds);
}

MotionFit searchAndStoreMotions(MotionCalibration& calibration, const MotionCalibrationTask& task, Session& session) {
  const bool descends = task.config.optimizer == "lm";
  const std::size_t per_round = static_cast<std::size_t>(calibration.posterior().size()) * task.motions.motions.size();
  const std::size_t total = descends ? per_round * static_cast<std::size_t>(task.config.rounds + 1)
                                     : static_cast<std::size_t>(task.config.strategy.generations);
  Progress progress(descends ? "calibrate: rollout" : "calibrate: generation", total, session.options().quiet);
  std::string detail;
  const auto rounds = [&] { return calibration.state().descent.history.size(); };
  const auto news = [&](const MotionSearchNews& now) {
    progress.update(descends ? rounds() * per_round + now.rollouts : now.rollouts, detail);
  };
  try {
    return calibration.run(news, [&](const MotionCalibrationState& state) {
      session.directory().write(kMotionState, toJson(state));
      if (descends) {
        detail = fmt::format("round {}: log posterior {:.1f}", rounds(), -state.descent.history.back().after);
      } else {
        detail = fmt::format("log posterior {:.1f}", -state.evolution.strategy.best.fitness);
        progress.update(static_cast<std::size_t>(state.evolution.strategy.generation), detail);
      }
    });
  } catch (const NumericsError& error) {
    session.abandon(std::string("failed: ") + error.what());
    throw;
  }
}

/// The search and its judgement. \throws InterruptedError with the command that goes on
MotionCalibrationResult calibrated(MotionCalibration& calibration, const MotionCalibrationTask& task,
                                   Session& session) try {
  return judgeMotions(task, calibration, searchAndStoreMotions(calibration, task, session));
} catch (const InterruptedError&) {
  const MotionCalibrationState& state = calibration.state();
  const bool descends = task.config.optimizer == "lm";
  throw InterruptedError(fmt::format("interrupted after {} {}; go on with: simgap calibrate --resume {}",
                                     descends ? state.descent.history.size() : state.evolution.history.size(),
                                     descends ? "rounds" : "generations",
                                     shellWord(session.directory().path().string())));
}

}  // namespace

void StrategyOptions::applyTo(const std::string& optimizer, const std::optional<std::uint64_t>& seed,
                              EvolutionStrategyOptions& strategy) const {
  constexpr int kSmallestPopulation = 5;  // of a CMA-ES in pagmo
  strategy.generations = generations.value_or(strategy.generations);
  strategy.mu = mu.value_or(strategy.mu);
  strategy.lambda = lambda.value_or(strategy.lambda);
  if (target_fitness) strategy.target_fitness = *target_fitness;
  strategy.seed = seed.value_or(strategy.seed);
  if (optimizer == "cma-es") {
    if (strategy.lambda < kSmallestPopulation) {
      throw ConfigError(fmt::format("found lambda = {} with --optimizer cma-es, expected at least {}", strategy.lambda,
                                    kSmallestPopulation));
    }
    // A CMA-ES weighs its whole population; only the evolution strategy has parents.
    strategy.mu = std::min(strategy.mu, strategy.lambda);
  }
  strategy.validate();
}

MotionSet readOtherMotions(Session& session, const std::string& file, const std::string& first, const ArmModel& model,
                           bool skip_bad_rows, double restart) {
  if (std::filesystem::weakly_canonical(file) == std::filesystem::weakly_canonical(first)) {
    throw ConfigError(
        fmt::format("--validation-motions {}: found the motions of --motions, expected others: what a "
                    "search has seen validates nothing",
                    file));
  }
  return readMotions(session, "validation", file, model, skip_bad_rows, restart);
}

bool holdsMotionCalibration(const std::filesystem::path& directory) {
  if (directory.empty()) return false;
  return shareFromFirstRank([&] { return Bytes(std::filesystem::exists(directory / kKeptFile) ? "yes" : "no"); }) ==
         "yes";
}

ExitCode calibrateMotions(const MotionCalibrateOptions& given, const std::vector<std::string>& argv) {
  const bool resuming = !given.resume.empty();
  const MotionCalibrateOptions options = resuming ? resumedMotionOptions(given) : given;
  Session session("calibrate", options.common, argv);
  const MotionCalibrationTask task = readMotionTask(session, options);
  MotionCalibration calibration(task);
  if (options.common.dry_run) {
    session.print(motionPlan(task, calibration.posterior()));
    return ExitCode::kDone;
  }
  if (resuming) {
    refuseChangedInputs(options.resume, session);
    session.resume(options.resume, task.config.strategy.seed);
    const std::filesystem::path file = session.directory().file(kMotionState);
    const Bytes stored =
        shareFromFirstRank([&] { return std::filesystem::exists(file) ? toText(readJson(file)) : Bytes(); });
    if (!stored.empty()) calibration.restore(Json::parse(stored));
  } else {
    session.begin(task.config.strategy.seed);
    keepMotionInputs(options, session, task);
  }
  const MotionCalibrationResult result = calibrated(calibration, task, session);
  writeMotionCalibration(result, session.directory());
  session.finish(toJson(result), terminalTable(result), result.failure.empty() ? "done" : "failed: " + result.failure);
  if (!result.failure.empty()) throw NumericsError(result.failure);
  return ExitCode::kDone;
}

}  // namespace simgap
