#include <fmt/format.h>
#include <spdlog/spdlog.h>

#include <cmath>

#include "cli/drive_command.h"
#include "cli/drive_subject.h"
#include "simgap/cli/command.h"
#include "simgap/core/csv.h"
#include "simgap/core/units.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/measure/logs/prepared_log.h"
#include "simgap/model/actuator/pam.h"

namespace simgap::commands {
namespace {

struct Options {
  CommonOptions common;
  TableOptions table;
  std::string model, log, motor, bench;
  bool inverse = false;
  std::optional<double> ratio;
};

/// A predicted column and, when the log has it, the measured one.
struct Prediction {
  std::string name, unit;
  std::vector<double> time, predicted, measured;
  std::size_t refused = 0;  ///< rows outside the model's range
};

/// The rig, with the ratio of the option or of the model.
Bench benchOf(const FittedModel& model, const Options& options, Session& session) {
  return readRig(session, options.bench,
                 options.ratio ? options.ratio : parseNumber(model.setting("transmission_ratio")));
}

FrictionDataOptions dataOptions(const FittedModel& model) {
  FrictionDataOptions options;
  for (const char* unit : {"rad_s", "m_s"}) {
    if (const auto band = parseNumber(model.setting(quantityName("dead_band", unit)))) options.dead_band = band;
  }
  return options;
}

/// A model of `diagnose`, its law with presliding and extensions, on the rows that mean something: what a motor draws,
/// the voltage of a winding, the force of a muscle.
Prediction predictDiagnosed(const FittedModel& model, const Options& options, Session& session) {
  if (model.kind == "gearbox" || options.inverse) {
    throw ConfigError(fmt::format("{}: found a diagnosed model {}, expected none there", options.model,
                                  options.inverse ? "with --inverse" : "in a gearbox model"));
  }
  const CsvTable table = session.readTable("log", options.log, options.table.csv());
  const ActuatorModel subject = subjectOf(model);
  const PreparedLog log = prepareLog(table, benchOf(model, options, session), subject.base.kind, dataOptions(model));
  const Eigen::ArrayXd predicted = predictExtended(subject, log.data);
  const UnitName effort = splitUnit(log.effort_column);
  Prediction result{effort.stem, effort.unit, {}, {}, {}, 0};
  for (Eigen::Index i = 0; i < predicted.size(); ++i) {
    if (!log.data.keep[static_cast<std::size_t>(i)]) continue;
    result.time.push_back(log.data.rows.time[i]);
    result.predicted.push_back(predicted[i]);
    result.measured.push_back(log.data.rows.effort[i]);
  }
  result.refused = static_cast<std::size_t>(predicted.size()) - result.time.size();
  return result;
}

Prediction predictFriction(const FittedModel& model, const Options& options, Session& session) {
  const CsvTable table = session.readTable("log", options.log, options.table.csv());
  const Bench bench = benchOf(model, options, session);
  const FrictionData data =
      prepareFrictionData(readActuatorLog(table, {.ratio = bench.ratio.value_or(0.0)}), bench, dataOptions(model));
  const FrictionLaw& law = friction::find(model.law);
  const DriveFeedForward drive = feedForward(law, model.parameters);
  const bool torque = model.setting("predicts") == "torque";
  Prediction result{
      torque ? "external_load" : data.effort_name, torque ? data.load_unit : data.effort_unit, {}, {}, {}, 0};
  std::vector<double> rig;
  for (const std::string& name : data.rig_names) rig.push_back(model.value(name));
  const Eigen::ArrayXd load = data.totalLoad(rig);
  for (Eigen::Index i = 0; i < load.size(); ++i) {
    result.time.push_back(data.time[i]);
    result.measured.push_back(torque ? load[i] : data.effort[i]);
    result.predicted.push_back(torque ? drive.load(data.effort[i], data.velocity[i], data.direction[i])
                                      : drive.effort(load[i], data.velocity[i], data.direction[i]));
  }
  result.refused = data.log_rows - data.rows();
  return result;
}

Prediction predictPam(const FittedModel& model, const Options& options, Session& session) {
  const CsvTable table = session.readTable("log", options.log, options.table.csv());
  const PamLog log = readPamLog(table);
  Pam muscle{model.value("a"), model.value("b"), model.value("c"),
             model.valueOr("k", std::numeric_limits<double>::infinity())};
  Prediction result{options.inverse ? "pressure" : "force", options.inverse ? "Pa" : "N", log.time, {}, {}, 0};
  result.measured = options.inverse ? log.pressure : log.force;
  for (std::size_t i = 0; i < log.rows(); ++i) {
    const auto value = options.inverse ? muscle.pressure(log.force[i], log.contraction[i])
                                       : muscle.force(log.pressure[i], log.contraction[i]);
    if (!value) ++result.refused;
    result.predicted.push_back(value.value_or(std::nan("")));
  }
  return result;
}

Prediction predictDrive(const FittedModel& model, const Options& options, Session& session) {
  const MotorLog log = readMotorLog(session.readTable("log", options.log, options.table.csv()));
  Motor motor;
  Gearbox gearbox;
  if (model.kind == "motor") {
    motor = motorFrom(model);
  } else {
    if (options.motor.empty()) throw ConfigError("a gearbox model needs --motor MODEL too");
    const Input& input = session.read("motor", options.motor);
    motor = motorFrom(readFittedModel(YamlNode::parse(input.content, options.motor), {"motor"}));
    gearbox = {parseNumber(model.setting("transmission_ratio")).value_or(1.0), model.value("eta"), model.value("J_G"),
               model.value("mu_G"), model.value("tau_CG")};
  }
  if (log.voltage.empty() && log.current.empty()) {
    throw DataError(log.file + ":1: found neither voltage_V nor current_A, expected one of them");
  }
  const DriveResponse response = simulateDrive(log, motor, gearbox);
  if (options.inverse) return {"current", "A", log.time, response.current, log.current, 0};
  return {"velocity", "rad_s", log.time, response.velocity, log.velocity, 0};
}

std::string toCsv(const Prediction& p) {
  std::vector<std::string> header;
  if (!p.time.empty()) header.emplace_back("time_s");
  header.push_back(quantityName(p.name + "_predicted", p.unit));
  if (!p.measured.empty()) header.push_back(quantityName(p.name + "_measured", p.unit));
  CsvWriter csv(header);
  for (std::size_t i = 0; i < p.predicted.size(); ++i) {
    if (!p.time.empty()) csv.add(p.time[i]);
    std::isfinite(p.predicted[i]) ? csv.add(p.predicted[i]) : csv.add("");
    if (!p.measured.empty()) csv.add(p.measured[i]);
    csv.endRow();
  }
  return csv.text();
}

ExitCode run(const Options& options, const std::vector<std::string>& argv, const CLI::App& app) {
  Session session("predict", options.common, argv);
  const Input& input = session.read("model", options.model);
  const FittedModel model = readFittedModel(YamlNode::parse(input.content, options.model));
  const bool diagnosed = !model.extensions.empty() || model.has("presliding");
  const Prediction p = diagnosed                  ? predictDiagnosed(model, options, session)
                       : model.kind == "friction" ? predictFriction(model, options, session)
                       : model.kind == "pam"      ? predictPam(model, options, session)
                                                  : predictDrive(model, options, session);
  double sum = 0.0;
  std::size_t count = 0;
  for (std::size_t i = 0; i < p.measured.size(); ++i) {
    if (!std::isfinite(p.predicted[i])) continue;
    sum += std::pow(p.predicted[i] - p.measured[i], 2);
    ++count;
  }
  const double rms = std::sqrt(sum / static_cast<double>(std::max<std::size_t>(count, 1)));
  if (options.common.dry_run) {
    fmt::print("would predict {} rows of {}; nothing was written\n", p.predicted.size(), options.log);
    return ExitCode::kDone;
  }
  session.begin(options.common.seed.value_or(0));
  session.directory().write("config.resolved.yaml", resolvedOptions(app));
  session.directory().write("prediction.csv", toCsv(p));
  Json result = {{"format", "simgap/predict/1"},
                 {"model", model.kind},
                 {"predicts", quantityName(p.name, p.unit)},
                 {"rows", p.predicted.size()},
                 {"left_out", p.refused}};
  result["rms_error"] = count > 0 ? Json(rms) : Json(nullptr);
  std::string text = fmt::format("{} predicted for {} rows: {}\n", quantityName(p.name, p.unit), p.predicted.size(),
                                 session.directory().file("prediction.csv").string());
  if (count > 0) text += fmt::format("RMS error against the log: {:.4g} {}\n", rms, p.unit);
  if (p.refused > 0) text += fmt::format("{} rows left out or outside the model's range\n", p.refused);
  session.finish(result, text);
  return ExitCode::kDone;
}

std::function<ExitCode()> define(CLI::App& app, const std::vector<std::string>& argv) {
  auto options = std::make_shared<Options>();
  app.add_option("MODEL", options->model, "fitted model (YAML of a fit-* command)")->required();
  app.add_option("LOG", options->log, "what to predict for (CSV)")->required();
  app.add_option("--motor", options->motor, "the motor's model, for a gearbox");
  app.add_option("--bench", options->bench, "the rig: where the load comes from (YAML)");
  app.add_option("--ratio", options->ratio, "motor turns per joint turn, to read joint channels")
      ->check(CLI::PositiveNumber & finiteNumber());
  app.add_flag("--inverse", options->inverse, "a muscle's pressure from force instead; a drive's current");
  options->table.add(app);
  options->common.add(app);
  return [options, argv, &app] { return run(*options, argv, app); };
}

}  // namespace

extern const Command predict;
const Command predict{"predict", "feed-forward current, force or pressure from a fitted model",
                      "  simgap predict runs/friction/model.yaml log.csv -o runs/prediction", define};

}  // namespace simgap::commands
