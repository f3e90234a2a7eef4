#include <fmt/format.h>
#include <malloc.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>

#include <algorithm>
#include <filesystem>
#include <thread>

#include "cli/diagnose_poses.h"
#include "cli/drive_subject.h"
#include "cli/fit_options.h"
#include "simgap/cli/command.h"
#include "simgap/core/progress.h"
#include "simgap/diagnose/logs/log_diagnosis.h"
#include "simgap/model/actuator/fitted_model.h"
#include "simgap/report/diagnosis/diagnosis_report.h"

namespace simgap::commands {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  std::string model, log, bench, poses, config;
  std::optional<double> ratio;
  std::optional<int> max_causes;
  std::string holdout;
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

/// One file per channel that what is left depends on: its shape.
void writeLeftovers(const Diagnosis& diagnosis, const RunDirectory& directory) {
  for (const Leftover& left : diagnosis.unexplained) {
    CsvWriter csv({left.channel, "mean_residual", "ci95", "rows"});
    for (const EvidenceBin& b : diagnosis.evidence) {
      if (b.against != left.channel) continue;
      csv.add(b.center).add(b.after).add(b.after_ci95).add(static_cast<double>(b.rows)).endRow();
    }
    directory.write("residual_" + left.channel + ".csv", csv.text());
  }
}

ExitCode run(const Options& given, const std::vector<std::string>& argv, const CLI::App& app) {
  const int threads =
      given.common.threads > 0 ? given.common.threads : static_cast<int>(std::thread::hardware_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  Options options = given;
  options.diagnose.seed = options.common.seed.value_or(1);
  if (options.max_causes) options.diagnose.max_causes = *options.max_causes;
  Session session("diagnose", options.common, argv);
  if (options.log.empty() == options.poses.empty()) {
    throw ConfigError("found neither or both of --log and --poses, expected one of them");
  }
  if (!options.poses.empty()) {
    const auto max_causes = static_cast<std::size_t>(options.max_causes.value_or(PoseDiagnosisOptions{}.max_causes));
    const PoseDiagnosisOptions pose_options{.effects = options.diagnose.effects,
                                            .max_causes = max_causes,
                                            .level = options.diagnose.level,
                                            .ignore_faults = options.diagnose.ignore_faults,
                                            .self_test = options.diagnose.self_tests,
                                            .threads = threads,
                                            .seed = options.diagnose.seed};
    return diagnosePoseFile(session, {options.model, options.poses, options.config, options.holdout},
                            options.table.csv(), options.common, pose_options);
  }
  keepMemory();
  FittedModel fitted;
  const ActuatorModel subject = readSubject(options.model, session, fitted);
  const Bench bench = readRig(session, options.bench, options.ratio);
  const CsvTable table = session.readTable("log", options.log, options.table.csv());
  if (table.skippedRows() > 0) spdlog::warn("{}: {} bad rows left out", options.log, table.skippedRows());
  PreparedLog log = prepareLog(table, bench, subject.base.kind);
  const Holdout holdout = readHoldout(options.holdout, table);
  if (holdout.fraction) options.diagnose.holdout = *holdout.fraction;
  options.diagnose.heldout_rows = holdout.rows;
  requireDiagnosable(log, options.diagnose);
  if (options.common.dry_run) {
    fmt::print("would diagnose {} on {} rows of {}; nothing was written\n", subject.base.name(), table.rows(),
               options.log);
    return ExitCode::kDone;
  }
  session.begin(options.diagnose.seed);
  session.directory().write("config.resolved.yaml", resolvedOptions(app));
  Progress progress("diagnose, %", 100, options.common.quiet);
  const LogDiagnosis result = diagnoseLog(subject, log, options.diagnose, [&](const std::string& what, double done) {
    progress.update(static_cast<std::size_t>(100.0 * done), what);
  });
  for (const std::string& warning : result.diagnosis.warnings) spdlog::warn("{}", warning);
  const RunDirectory& directory = session.directory();
  if (result.predicted_after.size() > 0) {
    for (const auto& [name, fit] : {std::pair("baseline.yaml", &result.baseline), {"model.yaml", &result.extended}}) {
      const FittedModel model =
          modelFile(fitted, subject, *fit, log.data, log.dead_band, result.diagnosis.samples, session.inputs().back());
      directory.write(name, writeFittedModel(model));
    }
    directory.write("predictions.csv",
                    predictionsCsv(log, {{"before", &result.predicted_before}, {"after", &result.predicted_after}}));
    directory.write("hypotheses.csv", hypothesesCsv(result.diagnosis));
    directory.write("evidence.csv", evidenceCsv(result.diagnosis));
    writeLeftovers(result.diagnosis, directory);
    if (result.diagnosis.self_test) directory.write("confusion.csv", confusionCsv(*result.diagnosis.self_test));
  }
  session.finish(toJson(result.diagnosis), terminalTable(result.diagnosis));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option(
         "MODEL", options->model,
         "fitted model of a drive, motor, gearbox or muscle, or arm model (YAML); or a name: a friction law (classic, "
         "variant-a, …), motor, gearbox or pam")
      ->required();
  app.add_option("--log", options->log, "measured log (CSV) of a drive");
  app.add_option("--poses", options->poses, "recorded poses (CSV) of an arm");
  app.add_option("--config", options->config,
                 "of --poses: calibration config with parameters and priors (default: the paper's)");
  app.add_option("--bench", options->bench, "the rig: where the load comes from (YAML; default: external_torque_Nm)");
  app.add_option("--ratio", options->ratio, "motor turns per joint turn, to read joint channels")
      ->check(CLI::PositiveNumber & finiteNumber());
  app.add_option(
      "--holdout", options->holdout,
      "what only measures the gain: a fraction of the blocks or poses (default 0.25), or COLUMN=VALUE,… of a log");
  app.add_option("--effects", options->diagnose.effects, "try these causes only (comma-separated)")->delimiter(',');
  app.add_option("--max-causes", options->max_causes, "stop after so many causes (default 4, of poses 8)")
      ->check(CLI::Range(1, 10));
  app.add_option("--level", options->diagnose.level, "false-alarm rate of each step")->check(CLI::Range(1e-6, 0.5));
  app.add_option("--self-test", options->diagnose.self_tests,
                 "hide every effect, and none, N times in this very log and count what is named")
      ->check(CLI::Range(1, 1000));
  app.add_flag("--ignore-faults", options->diagnose.ignore_faults, "go on where the data look wrong");
  options->table.add(app);
  options->common.add(app);
  return [options, argv, &app] { return run(*options, argv, app); };
}

}  // namespace

extern const Command diagnose;
const Command diagnose{"diagnose", "what the model gets wrong, the physical cause, and the gain on data never used",
                       "  simgap diagnose runs/friction/model.yaml --log log.csv -o runs/diagnosis\n"
                       "  simgap diagnose data/arm-dense/arm.yaml --poses data/arm-dense/poses_calibration.csv",
                       define};

}  // namespace simgap::commands
