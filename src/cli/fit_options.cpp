#include "fit_options.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <iterator>

#include "inputs.h"
#include "simgap/core/yaml.h"
#include "simgap/report/actuators/refit_report.h"

namespace simgap {
void FitOptions::add(CLI::App& app) {
  app.add_option("--fix", fix, "NAME=VALUE: a parameter that is known; may be repeated")->allow_extra_args(false);
  app.add_option("--bounds", bounds, "NAME=LOWER:UPPER in SI; may be repeated")->allow_extra_args(false);
  app.add_option("--sessions", sessions, "fit these sessions only (comma-separated)")->delimiter(',');
  app.add_option("--holdout", holdout,
                 "keep rows from the fit and judge it by them: a fraction of the blocks (0.2), or COLUMN=VALUE,… "
                 "(session=5,6); default: cross-validation over blocks where it is cheap");
  app.add_option("--block-s", block_s, "length of the blocks that are held out together [s]")->check(positiveNumber());
  app.add_option("--validate", validate, "another log to judge the fit by; may be repeated")->allow_extra_args(false);
}

std::string resolvedOptions(const CLI::App& app) {
  std::string text = "# every other option has its default\n";
  for (const CLI::Option* option : app.get_options()) {
    if (option->count() == 0) continue;
    std::vector<std::string> words;
    for (const std::string& word : option->results()) words.push_back(yamlText(word));
    text += fmt::format("{}: [{}]\n", option->get_single_name(), fmt::join(words, ", "));
  }
  return text;
}

void finishFit(Session& session, const CLI::App& app, FitSummary summary, const std::vector<std::string>& left_out,
               const std::function<void(const RunDirectory&)>& write) {
  session.begin(session.options().seed.value_or(0));
  session.directory().write("config.resolved.yaml", resolvedOptions(app));
  write(session.directory());
  std::ranges::copy(left_out, std::back_inserter(summary.warnings));
  session.finish(toJson(summary), terminalTable(summary));
}

ExitCode runRefit(const RefitOptions& options, Session& session, const CLI::App& app) {
  refuseOptions(app,
                {"--fix", "--bounds", "--sessions", "--holdout", "--block-s", "--validate", "--offset", "--loss",
                 "--predict", "--sign", "--dead-band", "--require", "--into", "--muscle", "--curves", "--tied"},
                fmt::format("with --model {}, expected no such option for a model's file", options.model));
  FittedModel given;
  const ActuatorModel subject = readSubject(session, options.model, given);
  if ("fit-" + given.kind != options.command) {
    throw ConfigError(fmt::format("{}: found a model of kind {}, expected {}: use fit-{}", options.model, given.kind,
                                  options.command.substr(4), given.kind));
  }
  const LogTable file_rows = readLog(session, "log", options.log, options.table);
  const CsvTable& table = file_rows.table;
  PreparedLog log = prepareLog(table, options.bench, subject.base.kind);
  std::ranges::copy(file_rows.summary(), std::back_inserter(log.warnings));
  if (session.options().dry_run) {
    session.print(
        fmt::format("would fit {} to {} rows of {}; nothing was written\n", options.model, table.rows(), options.log));
    return ExitCode::kDone;
  }
  const LogRefit refit = refitLog(subject, log);
  const Input& file = session.input("log");
  const FittedModel model =
      refittedModel(given, subject, refit.fit, log, {file.file.filename().string(), file.sha256, refit.rows});
  const FitSummary summary = summarise(options.command, log, model, refit);
  finishFit(session, app, summary, {},
            [&](const RunDirectory& directory) { writeRefit(summary, log, model, refit, directory); });
  return ExitCode::kDone;
}

}  // namespace simgap
