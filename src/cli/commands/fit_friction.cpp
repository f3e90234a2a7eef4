#include <fmt/format.h>
#include <spdlog/spdlog.h>
#include <tbb/global_control.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <optional>
#include <set>
#include <thread>

#include "cli/drive_subject.h"
#include "cli/fit_options.h"
#include "simgap/cli/command.h"
#include "simgap/report/actuators/friction_report.h"

namespace simgap::commands {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  FitOptions fit;
  std::string log, bench;
  std::vector<std::string> require;
  std::vector<std::string> models{"all"};
  std::string sign = "held", loss = "squares", predict = "effort";
  bool offset = false;
  std::optional<double> ratio, bandwidth;
  double dead_band = 3.5;
};

const std::vector<std::string> kPaperModels = {"classic", "variant-a", "variant-b"};

/// "all" are the three models of 003 table 2, "every" is every law there is.
std::vector<const FrictionLaw*> chosenLaws(const std::vector<std::string>& names) {
  std::vector<std::string> wanted;
  for (const std::string& name : names) {
    if (name == "all") {
      wanted.insert(wanted.end(), kPaperModels.begin(), kPaperModels.end());
    } else if (name == "every") {
      for (const FrictionLaw* law : friction::all()) wanted.emplace_back(law->name);
    } else {
      wanted.push_back(name);
    }
  }
  std::vector<const FrictionLaw*> laws;
  std::set<std::string> seen;
  for (const std::string& name : wanted) {
    if (seen.insert(name).second) laws.push_back(&friction::find(name));
  }
  return laws;
}

FrictionFitOptions fitOptions(const Options& options) {
  FrictionFitOptions fit;
  fit.fixed = options.fit.fixed();
  fit.bounds = options.fit.parameterBounds();
  fit.offset = options.offset;
  fit.predict_load = options.predict == "torque";
  const std::map<std::string, LossKind> losses = {{"squares", LossKind::kSquares},
                                                  {"huber", LossKind::kHuber},
                                                  {"cauchy", LossKind::kCauchy},
                                                  {"tukey", LossKind::kTukey}};
  fit.loss = losses.at(options.loss);
  return fit;
}

/// "NAME:DEG_PER_S:NM", or "paper" for 003 table 1.
std::vector<Requirement> requirements(const std::vector<std::string>& texts) {
  std::vector<Requirement> all;
  for (const std::string& text : texts) {
    if (text == "paper") {
      for (const Requirement& r : paperRequirements()) all.push_back(r);
      continue;
    }
    const std::size_t first = text.find(':'), last = text.rfind(':');
    const auto velocity = first < last ? parseNumber(text.substr(first + 1, last - first - 1)) : std::nullopt;
    const auto torque = first < last ? parseNumber(text.substr(last + 1)) : std::nullopt;
    if (!velocity || !torque) {
      throw ConfigError(fmt::format("--require: found '{}', expected NAME:DEG_PER_S:NM, or paper", text));
    }
    all.push_back({text.substr(0, first), unitConversion("deg_s", "rad_s")->operator()(*velocity), *torque});
  }
  return all;
}

/// Seconds from the first row of a session to its last, summed.
double spanOf(const ActuatorLog& log) {
  double seconds = 0.0;
  for (const Block& rows : splitRows(log.session, log.rows())) seconds += log.time[rows.end - 1] - log.time[rows.begin];
  return seconds;
}

/// A log with its rig, ready to be fitted.
struct Task {
  const Options& options;
  Bench bench;
  FrictionDataOptions data;
  ActuatorLogOptions log;

  FrictionData read(Session& session, const std::string& role, const std::string& file, Holdout* holdout) const {
    CsvTable table = session.readTable(role, file, options.table.csv());
    if (table.skippedRows() > 0) spdlog::warn("{}: {} bad rows left out", file, table.skippedRows());
    if (holdout != nullptr) *holdout = readHoldout(options.fit.holdout, table);
    ActuatorLog drive = readActuatorLog(std::move(table), log);
    FrictionDataOptions prepared = data;
    prepared.block_seconds = options.fit.blockSeconds(spanOf(drive));
    return prepareFrictionData(std::move(drive), bench, prepared);
  }
};

Task makeTask(const Options& options, Session& session) {
  Task task{options, readRig(session, options.bench, options.ratio), {}, {}};
  task.log.ratio = task.bench.ratio.value_or(0.0);
  task.data.raw_sign = options.sign == "raw";
  task.data.dead_band_widths = options.dead_band;
  task.data.bandwidth = options.bandwidth;
  task.data.sessions = options.fit.sessions;
  return task;
}

/// Laws that the log can answer; the reasons why the others were left out. All at once: each has stretches of its own
/// that only one thread can do.
std::vector<FrictionFit> fitAll(const std::vector<const FrictionLaw*>& laws, const FrictionData& data,
                                const FrictionFitOptions& options, std::vector<std::string>& left_out) {
  std::vector<std::optional<FrictionFit>> found(laws.size());
  std::vector<std::string> reasons(laws.size());
  tbb::parallel_for(std::size_t{0}, laws.size(), [&](std::size_t k) {
    try {
      found[k] = fitFriction(*laws[k], data, options);
    } catch (const DataError& error) {
      reasons[k] = error.what();
    }
  });
  std::vector<FrictionFit> fits;
  for (std::size_t k = 0; k < laws.size(); ++k) {
    if (found[k]) fits.push_back(std::move(*found[k]));
    if (!reasons[k].empty()) left_out.push_back(fmt::format("{} was left out: {}", laws[k]->name, reasons[k]));
  }
  if (fits.empty()) throw DataError(reasons.back());
  return fits;
}

ExitCode run(const Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  const int threads =
      options.common.threads > 0 ? options.common.threads : static_cast<int>(std::thread::hardware_concurrency());
  const tbb::global_control limit(tbb::global_control::max_allowed_parallelism, static_cast<std::size_t>(threads));
  Session session("fit-friction", options.common, argv);
  const Task task = makeTask(options, session);
  if (options.models.size() == 1 && namesFile(options.models[0])) {
    Bench bench = task.bench;
    if (options.bandwidth) bench.bandwidth = options.bandwidth;
    return fitExtended({"fit-friction", options.models[0], options.log, bench, options.table.csv()}, session,
                       options.common, app);
  }
  const std::vector<const FrictionLaw*> laws = chosenLaws(options.models);
  const FrictionFitOptions fit_options = fitOptions(options);
  Holdout holdout;
  const FrictionData all = task.read(session, "log", options.log, &holdout);
  const std::string log_sha256 = session.inputs().back().sha256;
  std::vector<ParameterSpec> known;
  for (const FrictionLaw* law : laws) {
    const auto more = makeFrictionProblem(*law, all, fit_options).parameters;
    known.insert(known.end(), more.begin(), more.end());
  }
  requireKnownParameters(options.fit, known);
  const std::vector<bool> held = heldOutRows(holdout, all.blocks, all.row);
  std::vector<bool> kept = held;
  kept.flip();
  const FrictionData training = holdout.any() ? selectRows(all, kept) : FrictionData();
  const FrictionData& data = holdout.any() ? training : all;
  std::vector<FrictionData> others;
  for (const std::string& file : options.fit.validate)
    others.push_back(task.read(session, "validation", file, nullptr));
  if (options.common.dry_run) {
    fmt::print("would fit {} models to {} rows of {}; nothing was written\n", laws.size(), data.rows(), options.log);
    return ExitCode::kDone;
  }

  FrictionReport report;
  report.data = &data;
  report.options = fit_options;
  report.ratio = task.bench.ratio;
  report.requirements = requirements(options.require);
  report.fits = fitAll(laws, data, fit_options, report.left_out);
  if (holdout.any()) {
    const FrictionData test = selectRows(all, held);
    for (FrictionFit& fit : report.fits) fit.mse_heldout = meanSquaredError(fit, test, fit_options);
    report.heldout = holdout.words;
  } else if (report.fits.front().mse_heldout) {
    report.heldout = fmt::format("{}-fold cross-validation over blocks of {:.3g} s",
                                 std::min<std::size_t>(5, data.blocks.size()), data.block_seconds);
  }
  report.best = compareFits(report.fits);
  for (const FrictionData& other : others) {
    report.transfer.push_back(
        {other.file, other.rows(), meanSquaredError(report.fits[report.best], other, fit_options)});
  }

  session.begin(options.common.seed.value_or(0));
  session.directory().write("config.resolved.yaml", resolvedOptions(app));
  writeFrictionReport(report, log_sha256, session.directory());
  const FitSummary summary = summarise(report);
  session.finish(toJson(summary), terminalTable(summary));
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("LOG", options->log, "actuator log (CSV)")->required();
  app.add_option(
         "--model", options->models,
         "friction laws, comma-separated; 'all': the three of the paper, 'every': all there are; or the file of a "
         "fitted or diagnosed model, whose law and extensions are fitted together")
      ->delimiter(',');
  app.add_option("--bench", options->bench, "the rig: where the load comes from (YAML; default: external_torque_Nm)");
  app.add_option("--ratio", options->ratio, "motor turns per joint turn, to read joint channels")
      ->check(CLI::PositiveNumber & finiteNumber());
  app.add_option("--bandwidth", options->bandwidth, "of the zero-phase smoothing of what was not logged [Hz]")
      ->check(CLI::PositiveNumber & finiteNumber());
  app.add_option("--sign", options->sign, "direction of motion: held through the noise, or 'raw' as in the paper")
      ->check(CLI::IsMember({"held", "raw"}));
  app.add_option("--dead-band", options->dead_band, "half width of the dead band in noise levels of the velocity")
      ->check(CLI::NonNegativeNumber & finiteNumber());
  app.add_flag("--offset", options->offset, "fit an offset of what is predicted, too");
  app.add_option("--predict", options->predict, "what the error is of: the motor's effort, or the load torque")
      ->check(CLI::IsMember({"effort", "torque"}));
  app.add_option("--loss", options->loss, "robust loss")->check(CLI::IsMember({"squares", "huber", "cauchy", "tukey"}));
  app.add_option("--require", options->require,
                 "working point the data should cover: NAME:DEG_PER_S:NM at the joint, or 'paper' (003 table 1)")
      ->allow_extra_args(false);
  return defineFit(options, app, argv, run);
}

}  // namespace

extern const Command fit_friction;
const Command fit_friction{"fit-friction", "friction of a drive from its log, with uncertainty and held-out error",
                           "  simgap fit-friction log.csv --model all -o runs/friction", define};

}  // namespace simgap::commands
