#include <fmt/format.h>

#include <algorithm>
#include <iterator>
#include <optional>

#include "cli/fit_options.h"
#include "cli/inputs.h"
#include "simgap/cli/command.h"
#include "simgap/fit/actuators/holdout.h"
#include "simgap/report/actuators/friction_report.h"

namespace simgap::commands::fit_friction {
namespace {

struct Options {
  CommonOptions common;
  LogFileOptions table;
  FitOptions fit;
  std::string log, bench;
  std::vector<std::string> require;
  std::vector<std::string> models{"all"};
  std::string sign = "held", loss = "squares", predict = "effort";
  bool offset = false;
  std::optional<double> ratio, bandwidth;
  double dead_band = 3.5;
};

FrictionFitOptions fitOptions(const Options& options) {
  FrictionFitOptions fit;
  const ParameterChoices choices = options.fit.parameters();
  fit.fixed = choices.fixed;
  fit.bounds = choices.bounds;
  fit.offset = options.offset;
  fit.predict_load = options.predict == "torque";
  const std::map<std::string, LossKind> losses = {{"squares", LossKind::kSquares},
                                                  {"huber", LossKind::kHuber},
                                                  {"cauchy", LossKind::kCauchy},
                                                  {"tukey", LossKind::kTukey}};
  fit.loss = losses.at(options.loss);
  return fit;
}

/// Seconds from the first row of a session to its last, summed.
double spanOf(const ActuatorLog& log) {
  double seconds = 0.0;
  for (const Block& rows : splitRows(log.session, log.rows())) seconds += log.time[rows.end - 1] - log.time[rows.begin];
  return seconds;
}

const std::vector<std::string> kAllSessions;

/// What only the log that is fitted has to tell besides.
struct OfFitted {
  Holdout holdout;
  std::vector<double> position;
};

/// A log with its rig, ready to be fitted.
struct Task {
  const Options& options;
  Bench bench;
  FrictionDataOptions data;
  ActuatorLogOptions log;

  FrictionData read(Session& session, const std::string& role, const std::string& file, OfFitted* own) const {
    const bool fitted = own != nullptr;
    LogTable rows = readLog(session, role, file, options.table, fitted ? options.fit.sessions : kAllSessions);
    if (fitted) own->holdout = readHoldout(options.fit.holdout, rows.table);
    const std::vector<std::string> left_out = rows.summary();
    ActuatorLog drive = readActuatorLog(std::move(rows.table), log);
    if (fitted) own->position = drive.position;
    FrictionDataOptions prepared = data;
    prepared.block_seconds = blockSeconds(options.fit.block_s, spanOf(drive));
    FrictionData result = prepareFrictionData(std::move(drive), bench, prepared);
    std::ranges::copy(left_out, std::back_inserter(result.warnings));
    return result;
  }
};

Task makeTask(const Options& options, Session& session) {
  Task task{options, readRig(session, options.bench, options.ratio), {}, {}};
  task.log.ratio = task.bench.ratio.value_or(0.0);
  task.data.raw_sign = options.sign == "raw";
  task.data.load_is_fitted = options.predict == "torque";
  task.data.dead_band_widths = options.dead_band;
  task.data.bandwidth = options.bandwidth;
  return task;
}

ExitCode runLaws(const Options& options, const Task& task, Session& session, const CLI::App& app) {
  const std::vector<const FrictionLaw*> laws = lawsNamed(options.models);
  FrictionReport report;
  report.options = fitOptions(options);
  report.ratio = task.bench.ratio;
  report.requirements = readRequirements(options.require);
  OfFitted own;
  const FrictionData all = task.read(session, "log", options.log, &own);
  if (!options.require.empty() && all.velocity_unit != "rad_s") {
    throw ConfigError(fmt::format("found --require with {} of a linear axis, expected it with a joint's", options.log));
  }
  const Holdout& holdout = own.holdout;
  report.position = std::move(own.position);
  requireKnown({report.options.fixed, report.options.bounds}, parameterNames(laws, all, report.options));
  std::optional<FrictionData> training, test;
  if (holdout.any()) {
    std::vector<bool> rows = fittedRows(holdout, all.blocks, all.row);
    training = selectRows(all, rows);
    rows.flip();
    test = selectRows(all, rows);
  }
  report.data = training ? &*training : &all;
  std::vector<FrictionData> others;
  for (const std::string& file : options.fit.validate) {
    others.push_back(task.read(session, "validation", file, nullptr));
  }
  if (options.common.dry_run) {
    session.print(fmt::format("would fit {} models to {} rows of {}; nothing was written\n", laws.size(),
                              report.data->rows(), options.log));
    return ExitCode::kDone;
  }
  report.laws = compareLaws(laws, *report.data, report.options, test ? &*test : nullptr, holdout.words);
  for (const FrictionData& other : others) {
    report.transfer.push_back({other.file, other.rows(), meanSquaredError(report.best(), other, report.options)});
  }
  finishFit(session, app, summarise(report), {}, [&](const RunDirectory& directory) {
    writeFrictionReport(report, session.input("log").sha256, directory);
  });
  return ExitCode::kDone;
}

ExitCode run(const Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("fit-friction", options.common, argv);
  if (options.sign == "raw") refuseOptions(app, {"--dead-band"}, "with --sign raw, expected it with --sign held");
  const Task task = makeTask(options, session);
  if (!options.require.empty() && !task.bench.ratio) {
    throw ConfigError("found --require without a ratio, expected --ratio: the working point is one of the joint");
  }
  if (options.models.size() != 1 || !namesFile(options.models[0])) return runLaws(options, task, session, app);
  Bench bench = task.bench;
  if (options.bandwidth) bench.bandwidth = options.bandwidth;
  return runRefit({"fit-friction", options.models[0], options.log, options.table, bench}, session, app);
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("LOG", options->log, "actuator log (CSV, or a recording with --topic)")->required();
  app.add_option(
         "--model", options->models,
         "friction laws, comma-separated; 'all': the three of the paper, 'every': all there are; or the file of a "
         "fitted or diagnosed model, whose law and extensions are fitted together")
      ->delimiter(',');
  app.add_option("--bench", options->bench, "the rig: where the load comes from (YAML; default: external_torque_Nm)");
  app.add_option("--ratio", options->ratio, "motor turns per joint turn, to read joint channels")
      ->check(positiveNumber());
  app.add_option("--bandwidth", options->bandwidth, "of the zero-phase smoothing of what was not logged [Hz]")
      ->check(positiveNumber());
  app.add_option("--sign", options->sign, "direction of motion: held through the noise, or 'raw' as in the paper")
      ->check(CLI::IsMember({"held", "raw"}));
  app.add_option("--dead-band", options->dead_band, "half width of the dead band in noise levels of the velocity")
      ->check(CLI::NonNegativeNumber & finiteNumber());
  app.add_flag("--offset", options->offset, "fit an offset of what is predicted, too");
  app.add_option("--predict", options->predict, "what the error is of: the motor's effort, or the load torque")
      ->check(CLI::IsMember({"effort", "torque"}));
  app.add_option("--loss", options->loss, "robust loss")->check(CLI::IsMember({"squares", "huber", "cauchy", "tukey"}));
  app.add_option("--require", options->require,
                 "working point the data should cover: NAME:DEG_PER_S:NM at the joint, or 'paper'")
      ->allow_extra_args(false);
  return defineFit(options, app, argv, run);
}

}  // namespace

extern const Command entry;
const Command entry{"fit-friction", "friction of a drive from its log, with uncertainty and held-out error",
                    "  simgap fit-friction data/logs/bend-friction.csv.gz --model all \\\n"
                    "    -o runs/friction\n"
                    "  simgap fit-friction data/logs/bend.mcap -o runs/bend \\\n"
                    "    --topic /joint_states:bend --topic /motor/current --topic /load/torque \\\n"
                    "    --map motor_velocity_rad_s=bend.velocity \\\n"
                    "    --map motor_current_A=motor/current \\\n"
                    "    --map external_torque_Nm=load/torque",
                    define};

}  // namespace simgap::commands::fit_friction
