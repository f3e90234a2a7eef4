#include "drive_subject.h"

#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <algorithm>
#include <cmath>
#include <filesystem>

#include "fit_options.h"
#include "simgap/core/error.h"
#include "simgap/core/units.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap {
namespace {

/// Of a winding or a muscle: what was fitted replaces what the file had; the spring of 002 is a parameter there.
void takeOver(const LogFit& fit, FittedModel& model) {
  const auto put = [&](const Estimate& parameter) {
    std::erase_if(model.parameters, [&](const Estimate& p) { return p.name == parameter.name; });
    model.parameters.push_back(parameter);
  };
  for (const Estimate& p : fit.parameters) {
    if (p.name.find('.') == std::string::npos) put({p.name, p.unit, p.value, p.sd});
  }
  if (model.kind != "pam") return;
  model.law = "no-spring";
  std::erase_if(model.parameters, [](const Estimate& p) { return p.name == "k"; });
  const auto spring = std::ranges::find(model.extensions, "tendon-compliance", &Extension::effect);
  if (spring == model.extensions.end()) return;
  const Estimate& compliance = spring->parameters[0];
  model.law = "spring";
  put({"k", "N", 1.0 / compliance.value, compliance.sd / (compliance.value * compliance.value)});
  model.extensions.erase(spring);
}

FitSummary summarise(const std::string& command, const PreparedLog& log, const FittedModel& model,
                     const LogRefit& refit) {
  FitSummary summary;
  summary.command = command;
  summary.model = model.law.empty() ? model.kind : model.law;
  for (const Extension& e : model.extensions) summary.model += " + " + e.effect;
  summary.target = splitUnit(log.effort_column).stem;
  summary.target_unit = log.data.effort_unit;
  for (const Estimate& p : refit.fit.parameters) {
    const double half = refit.fit.t * p.sd;
    Estimate e = p;
    e.identifiable = std::isfinite(p.sd);
    e.lower95 = p.value - half;
    e.upper95 = p.value + half;
    summary.uncertainty.estimates.push_back(std::move(e));
  }
  summary.uncertainty.n_effective = refit.effective_samples;
  summary.mse = refit.mse;
  summary.mse_heldout = refit.mse_heldout;
  summary.heldout = "5-fold cross-validation over blocks";
  summary.n = refit.rows;
  summary.starts = summary.distinct_minima = 1;
  summary.comparison.push_back({summary.model, refit.fit.parameters.size(), refit.mse, refit.mse_heldout, 0.0});
  summary.warnings = log.warnings;
  return summary;
}

}  // namespace

bool namesFile(const std::string& model) {
  return std::filesystem::exists(model) || model.find('.') != std::string::npos;
}

ActuatorModel readSubject(const std::string& model, Session& session, FittedModel& fitted) {
  if (!namesFile(model)) return subjectOf(model);
  const Input& input = session.read("model", model);
  fitted = readFittedModel(YamlNode::parse(input.content, model));
  return subjectOf(fitted);
}

Bench readRig(Session& session, const std::string& file, std::optional<double> ratio) {
  Bench bench;
  if (!file.empty()) bench = readBench(YamlNode::parse(session.read("bench", file).content, file));
  if (ratio) bench.ratio = ratio;
  return bench;
}

PreparedLog prepareLog(const CsvTable& table, const Bench& bench, ActuatorKind kind, FrictionDataOptions data_options) {
  if (kind == ActuatorKind::kMotor) return prepareMotorData(table);
  if (kind == ActuatorKind::kPam) return preparePamData(table);
  const ActuatorLogOptions log_options{.ratio = bench.ratio.value_or(0.0)};
  data_options.bandwidth = bench.bandwidth;
  if (kind == ActuatorKind::kGearbox) return prepareGearboxData(table, bench, log_options, data_options);
  return prepareActuatorData(table, bench, log_options, data_options);
}

FittedModel modelFile(const FittedModel& given, const ActuatorModel& subject, const LogFit& fit,
                      const ActuatorData& data, double dead_band, std::size_t rows, const Input& log) {
  FittedModel model = given;
  const ActuatorKind kind = subject.base.kind;
  model.covariance.resize(0, 0);
  model.data_file = log.file.filename().string();
  model.data_sha256 = log.sha256;
  model.data_rows = rows;
  model.extensions = fit.extensions;
  if (kind == ActuatorKind::kMotor || kind == ActuatorKind::kPam) {
    model.kind = kind == ActuatorKind::kMotor ? "motor" : "pam";
    takeOver(fit, model);
    return model;
  }
  model.kind = "friction";
  model.law = subject.base.name();
  model.parameters.clear();
  for (const Estimate& p : fit.parameters) {
    const bool own = p.name.find('.') == std::string::npos;
    if (own) model.parameters.push_back({p.name, p.unit, p.value, p.sd});
  }
  model.settings["effort"] = data.effort_unit;
  model.settings.try_emplace("predicts", "effort");
  model.settings[quantityName("dead_band", data.velocity_unit)] = fmt::format("{}", dead_band);
  return model;
}

std::string predictionsCsv(const PreparedLog& log,
                           const std::vector<std::pair<std::string, const Eigen::ArrayXd*>>& predictions) {
  std::vector<std::string> header{"time_s", "measured"};
  for (const auto& [name, values] : predictions) header.push_back(name);
  header.emplace_back("used");
  CsvWriter csv(header);
  for (Eigen::Index i = 0; i < log.data.rows.rows(); ++i) {
    csv.add(log.data.rows.time[i]).add(log.data.rows.effort[i]);
    for (const auto& [name, values] : predictions) csv.add((*values)[i]);
    csv.add(log.data.keep[static_cast<std::size_t>(i)] ? 1.0 : 0.0).endRow();
  }
  return csv.text();
}

ExitCode fitExtended(const ExtendedFitOptions& options, Session& session, const CommonOptions& common,
                     const CLI::App& app) {
  for (const char* name :
       {"--fix", "--bounds", "--sessions", "--holdout", "--block-s", "--validate", "--offset", "--loss", "--predict",
        "--sign", "--dead-band", "--require", "--into", "--muscle", "--curves", "--tied"}) {
    const CLI::Option* option = app.get_option_no_throw(name);
    if (option != nullptr && option->count() > 0) {
      throw ConfigError(
          fmt::format("found {} with --model {}, expected no such option for a model's file", name, options.model));
    }
  }
  FittedModel given;
  const ActuatorModel subject = readSubject(options.model, session, given);
  if ("fit-" + given.kind != options.command) {
    throw ConfigError(fmt::format("{}: found a model of kind {}, expected {}: use fit-{}", options.model, given.kind,
                                  options.command.substr(4), given.kind));
  }
  const CsvTable table = session.readTable("log", options.log, options.csv);
  const Input log_file = session.inputs().back();
  if (table.skippedRows() > 0) spdlog::warn("{}: {} bad rows left out", options.log, table.skippedRows());
  const PreparedLog log = prepareLog(table, options.bench, subject.base.kind);
  if (common.dry_run) {
    fmt::print("would fit {} to {} rows of {}; nothing was written\n", options.model, table.rows(), options.log);
    return ExitCode::kDone;
  }
  const LogRefit refit = refitLog(subject, log);
  session.begin(common.seed.value_or(0));
  const RunDirectory& directory = session.directory();
  directory.write("config.resolved.yaml", resolvedOptions(app));
  const FittedModel model = modelFile(given, subject, refit.fit, log.data, log.dead_band, refit.rows, log_file);
  directory.write("model.yaml", writeFittedModel(model));
  directory.write("predictions.csv", predictionsCsv(log, {{"predicted", &refit.predicted}}));
  const FitSummary summary = summarise(options.command, log, model, refit);
  directory.write("parameters.csv", parametersCsv(summary));
  session.finish(toJson(summary), terminalTable(summary));
  return ExitCode::kDone;
}

}  // namespace simgap
