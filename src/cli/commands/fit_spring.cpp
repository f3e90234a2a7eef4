#include <fmt/format.h>

#include <algorithm>

#include "cli/drive_command.h"
#include "cli/inputs.h"
#include "simgap/cli/command.h"
#include "simgap/measure/logs/spring_log.h"
#include "simgap/report/actuators/spring_report.h"

namespace simgap::commands::fit_spring {
namespace {

struct Options {
  CommonOptions common;
  LogFileOptions table;
  FitOptions fit;
  std::string log, model, into, muscle;
};

ExitCode run(const Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("fit-spring", options.common, argv);
  if (!options.model.empty()) return runRefit({"fit-spring", options.model, options.log, options.table}, session, app);
  const ParameterChoices choices = options.fit.parameters();
  requireKnown(choices, springParameterNames());

  SpringReport report;
  report.into = readTarget(options.into, options.muscle, session);
  const LogTable file_rows = readLog(session, "log", options.log, options.table, options.fit.sessions);
  const CsvTable& table = file_rows.table;
  const Holdout holdout = readHoldout(options.fit.holdout, table);
  const SpringLog spring = readSignedSpringLog(table);
  if (report.into && spring.angular) {
    throw DataError(fmt::format("{}: found a torque over an angle, expected a force over a length for a muscle's cord",
                                spring.file));
  }
  report.own_length = spring.own_length;
  report.log = prepareLog(table, {}, ActuatorKind::kSpring);
  report.log_sha256 = session.input("log").sha256;
  report.comparison = compareSprings(report.log, {false, choices.fixed, choices.bounds}, holdout, options.fit.block_s);
  for (const std::string& file : options.fit.validate) {
    const PreparedLog other =
        prepareLog(readLog(session, "validation", file, options.table).table, {}, ActuatorKind::kSpring);
    const auto rows = static_cast<std::size_t>(std::ranges::count(other.data.keep, true));
    report.transfer.push_back({file, rows, meanSquaredError(report.comparison.chosen().fit, other, {})});
  }
  if (options.common.dry_run) {
    session.print(fmt::format("would fit a spring to {} rows of {}; nothing was written\n", table.rows(), options.log));
    return ExitCode::kDone;
  }
  finishFit(session, app, summarise(report), file_rows.summary(),
            [&](const RunDirectory& directory) { writeSpringReport(report, directory); });
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option(
         "LOG", options->log,
         "log of the spring (CSV: force_N with deflection_m, or with length_m, its own length; or torque_Nm with "
         "deflection_rad; time_s, session)")
      ->required();
  app.add_option("--model", options->model,
                 "a diagnosed spring (YAML): its equation and its extensions are fitted together");
  app.add_option("--into", options->into,
                 "arm model (YAML) to write the cord into; the copy lands in the result directory");
  app.add_option("--muscle", options->muscle, "whose cord it is");
  return defineFit(options, app, argv, run);
}

}  // namespace

extern const Command entry;
const Command entry{"fit-spring", "stiffness, offset and damping of a spring, a shock cord or a tendon",
                    "  simgap fit-spring data/logs/shock-cord.csv.gz -o runs/spring\n"
                    "  simgap fit-spring data/logs/shock-cord.csv.gz \\\n"
                    "    --into data/arm/arm.yaml --muscle biceps -o runs/spring-arm",
                    define};

}  // namespace simgap::commands::fit_spring
