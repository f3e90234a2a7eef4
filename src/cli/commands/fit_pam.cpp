#include <fmt/format.h>

#include "cli/fit_options.h"
#include "cli/inputs.h"
#include "simgap/cli/command.h"
#include "simgap/report/actuators/pam_report.h"

namespace simgap::commands::fit_pam {
namespace {

struct Options {
  CommonOptions common;
  LogFileOptions table;
  FitOptions fit;
  std::string log, curves, model;
  bool tied = false;
};

const std::vector<std::string> kParameters = {"a", "b", "c", "k"};

ExitCode run(const Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("fit-pam", options.common, argv);
  if (!options.model.empty()) return runRefit({"fit-pam", options.model, options.log, options.table}, session, app);
  const ParameterChoices choices = options.fit.parameters();
  requireKnown(choices, kParameters);

  PamReport report;
  if (!options.curves.empty()) {
    report.maker_file = options.curves;
    report.maker = fitPam(readPamLog(readLog(session, "curves", options.curves, options.table).table),
                          {false, options.tied, {}, {}});
  }
  const LogTable rows = readLog(session, "log", options.log, options.table, options.fit.sessions);
  const Holdout holdout = readHoldout(options.fit.holdout, rows.table);
  report.log = readPamLog(rows.table);
  report.log_sha256 = session.input("log").sha256;
  report.comparison = comparePam(report.log, {false, options.tied, choices.fixed, choices.bounds}, report.maker,
                                 holdout, options.fit.block_s);
  for (const std::string& file : options.fit.validate) {
    const PamLog other = readPamLog(readLog(session, "validation", file, options.table).table);
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
