#include <fmt/format.h>

#include "cli/fit_options.h"
#include "cli/inputs.h"
#include "simgap/cli/command.h"
#include "simgap/model/actuator/exo_joint.h"
#include "simgap/report/actuators/pam_report.h"

namespace simgap::commands::fit_pam {
namespace {

struct Options {
  CommonOptions common;
  LogFileOptions table;
  FitOptions fit;
  std::string log, curves, model, joint;
  bool tied = false;
};

/// The log of a muscle, or of the joint that it turns.
PamLog readMuscleLog(const CsvTable& table, const std::optional<MusclePulley>& pulley) {
  PamLog log = pulley ? readJointPamLog(table, *pulley) : readPamLog(table);
  repairSpikes(log);
  return log;
}

std::optional<MusclePulley> readJoint(Session& session, const std::string& file) {
  if (file.empty()) return std::nullopt;
  const AntagonistJoint joint = readPulley(YamlNode::parse(session.read("joint", file).content, file));
  return MusclePulley{joint.radius, joint.length, joint.rest_flexor, joint.rest_extensor};
}

const std::vector<std::string> kParameters = {"a", "b", "c", "k"};

ExitCode run(const Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("fit-pam", options.common, argv);
  if (!options.model.empty() && !options.joint.empty()) {
    throw ConfigError(
        "found --joint with --model, expected a log of the muscle there (pressure_Pa, contraction, force_N)");
  }
  if (!options.model.empty()) return runRefit({"fit-pam", options.model, options.log, options.table}, session, app);
  const ParameterChoices choices = options.fit.parameters();
  requireKnown(choices, kParameters);

  const std::optional<MusclePulley> pulley = readJoint(session, options.joint);
  PamReport report;
  if (!options.curves.empty()) {
    report.maker_file = options.curves;
    report.maker = fitPam(readPamLog(readLog(session, "curves", options.curves, options.table).table),
                          {false, options.tied, {}, {}});
  }
  const LogTable rows = readLog(session, "log", options.log, options.table, options.fit.sessions);
  const Holdout holdout = readHoldout(options.fit.holdout, rows.table);
  report.log = readMuscleLog(rows.table, pulley);
  report.log_sha256 = session.input("log").sha256;
  report.comparison = comparePam(report.log, {false, options.tied, choices.fixed, choices.bounds}, report.maker,
                                 holdout, options.fit.block_s);
  for (const std::string& file : options.fit.validate) {
    const PamLog other = readMuscleLog(readLog(session, "validation", file, options.table).table, pulley);
    report.transfer.push_back({file, other.rows(), meanSquaredError(report.comparison.chosen().fit, other, {})});
  }
  if (options.common.dry_run) {
    session.print(
        fmt::format("would fit a muscle to {} rows of {}; nothing was written\n", report.log.rows(), options.log));
    return ExitCode::kDone;
  }
  finishFit(session, app, summarise(report), rows.summary(),
            [&](const RunDirectory& directory) { writePamReport(report, directory); });
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("LOG", options->log, "log of the muscle (CSV: pressure_Pa, contraction, force_N)")->required();
  app.add_option("--model", options->model,
                 "a diagnosed muscle (YAML): its equation and its extensions are fitted together");
  app.add_option("--curves", options->curves,
                 "the maker's curves (CSV, the same columns): a, b, c come from them, k from LOG, as in the paper");
  app.add_option("--joint", options->joint,
                 "the joint (YAML) that two of them turn: LOG then has angle_rad, muscle_torque_Nm, "
                 "pressure_flexor_Pa, pressure_extensor_Pa");
  app.add_flag("--tied", options->tied, "b = -2a, as the muscle's geometry demands");
  return defineFit(options, app, argv, run);
}

}  // namespace

extern const Command entry;
const Command entry{"fit-pam", "force model of a pneumatic muscle, with and without its tendon's spring",
                    "  simgap fit-pam data/logs/muscle.csv.gz \\\n"
                    "    --curves data/logs/muscle-curves.csv.gz -o runs/pam",
                    define};

}  // namespace simgap::commands::fit_pam
