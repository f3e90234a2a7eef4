#include "drive_command.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/cli/command.h"
#include "simgap/core/error.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap {
namespace {

constexpr std::size_t kMotorParameters = 7;

struct ArmKey {
  const char* parameter;
  const char* key;  ///< below muscles.NAME; empty when a calibration cannot search it
};
constexpr ArmKey kArmKeys[] = {{"R", "motor.resistance_ohm"},
                               {"L", "motor.inductance_H"},
                               {"K_E", "motor.back_emf_constant_Vs"},
                               {"K_T", "motor.torque_constant_Nm_A"},
                               {"J_M", "motor.inertia_kg_m2"},
                               {"mu_M", "motor.viscous_friction_Nms"},
                               {"tau_CM", "motor.coulomb_friction_Nm"},
                               {"eta", "gearbox.efficiency"},
                               {"mu_G", "gearbox.viscous_friction_Nms"},
                               {"tau_CG", "gearbox.coulomb_friction_Nm"}};

/// The estimates that belong to the kind: a motor's seven, or a gearbox's four.
Uncertainty partOf(const Uncertainty& all, const std::string& kind) {
  Uncertainty part = all;
  const std::size_t begin = kind == "motor" ? 0 : kMotorParameters;
  const std::size_t count = kind == "motor" ? kMotorParameters : all.estimates.size() - kMotorParameters;
  const auto first = all.estimates.begin() + static_cast<std::ptrdiff_t>(begin);
  part.estimates.assign(first, first + static_cast<std::ptrdiff_t>(count));
  const auto b = static_cast<Eigen::Index>(begin), n = static_cast<Eigen::Index>(count);
  part.covariance = all.covariance.block(b, b, n, n);
  part.correlation = all.correlation.block(b, b, n, n);
  return part;
}

FitSummary summarise(const std::string& kind, const DriveFit& fit, const std::optional<DriveFit>& trained,
                     const std::string& heldout) {
  FitSummary summary;
  summary.command = "fit-" + kind;
  summary.model = kind;
  const DriveChannel& target = fit.channels.front();
  summary.target = target.name;
  summary.target_unit = target.unit;
  summary.uncertainty = partOf(fit.uncertainty, kind);
  summary.mse = target.rms * target.rms;
  const DriveFit& judged = trained ? *trained : fit;
  if (judged.channels.front().rms_heldout) {
    summary.mse_heldout = std::pow(*judged.channels.front().rms_heldout, 2);
    summary.heldout = heldout;
  }
  summary.n = fit.rows;
  summary.starts = fit.starts;
  summary.distinct_minima = fit.distinct_minima;
  summary.comparison.push_back({kind, 0, summary.mse, summary.mse_heldout, 0.0});
  summary.warnings = fit.warnings;
  for (std::size_t c = 0; c < fit.channels.size(); ++c) {
    const DriveChannel& channel = fit.channels[c];
    const auto out = judged.channels[c].rms_heldout;
    summary.facts.emplace_back(
        "simulated " + channel.name,
        fmt::format("RMS {:.4g} {}{}, {:.1f} % of the measurement's spread", channel.rms, channel.unit,
                    out ? fmt::format(" (held out {:.4g})", *out) : "", 100.0 * channel.rms / channel.spread));
  }
  return summary;
}

std::string responseCsv(const MotorLog& log, const DriveResponse& response) {
  std::vector<std::string> header{"time_s", "velocity_simulated_rad_s", "current_simulated_A"};
  if (!log.velocity.empty()) header.emplace_back("velocity_measured_rad_s");
  if (!log.current.empty()) header.emplace_back("current_measured_A");
  CsvWriter csv(header);
  for (std::size_t i = 0; i < log.rows(); ++i) {
    csv.add(log.time[i]).add(response.velocity[i]).add(response.current[i]);
    if (!log.velocity.empty()) csv.add(log.velocity[i]);
    if (!log.current.empty()) csv.add(log.current[i]);
    csv.endRow();
  }
  return csv.text();
}

/// The arm with the fitted drive in one muscle, and the priors a calibration of it may start from.
void writeInto(const std::string& kind, const DriveCommandOptions& options, const ArmModel& arm, std::size_t muscle,
               const DriveFit& fit, double ratio, const Uncertainty& part, const RunDirectory& directory) {
  ArmModel with = arm;
  Muscle& m = with.muscles[muscle];
  if (kind == "motor") {
    const double supply = m.motor.supply_voltage;
    m.motor = motorOf(fit.theta);
    m.motor.supply_voltage = supply;
  } else {
    m.gearbox = gearboxOf(fit.theta, ratio);
  }
  directory.write("arm.yaml", writeArm(with));
  std::string text = fmt::format(
      "# For the `parameters:` of a calibration config; the covariance stands in model.yaml.\nparameters:\n");
  for (const Estimate& e : part.estimates) {
    const auto key = std::ranges::find_if(kArmKeys, [&](const ArmKey& k) { return e.name == k.parameter; });
    if (key == std::end(kArmKeys) || e.fixed || !std::isfinite(e.sd) || e.sd <= 0.0) continue;
    text += fmt::format("  - {{pattern: \"muscles.{}.{}\", step: {:.6g}, prior_sd: {:.6g}}}\n", options.muscle,
                        key->key, e.sd, e.sd);
  }
  directory.write("calibration_parameters.yaml", text);
}

}  // namespace

void DriveCommandOptions::add(CLI::App& command) {
  app = &command;
  command
      .add_option("LOG", log,
                  "log of the drive (CSV: time_s and what there is of voltage_V, current_A, velocity_rad_s, "
                  "load_torque_Nm)")
      ->required();
  command.add_option("--into", into,
                     "arm model (YAML) to write the result into; the copy lands in the result directory");
  command.add_option("--muscle", muscle, "whose drive it is");
  fit.add(command);
  table.add(command);
  common.add(command);
}

Motor motorFrom(const FittedModel& model) {
  return {model.value("R"),   model.value("L"),    model.value("K_E"),    model.value("K_T"),
          model.value("J_M"), model.value("mu_M"), model.value("tau_CM"), 0.0};
}

ExitCode runDriveFit(const std::string& kind, const DriveCommandOptions& options, Session& session,
                     DriveFitOptions drive) {
  if (options.into.empty() != options.muscle.empty()) throw ConfigError("--into and --muscle go together");
  std::optional<ArmModel> arm;
  std::size_t muscle = 0;
  if (!options.into.empty()) {
    const Input& input = session.read("arm", options.into);
    arm = readArm(YamlNode::parse(input.content, options.into));
    const auto found = std::ranges::find(arm->muscles, options.muscle, &Muscle::name);
    if (found == arm->muscles.end()) {
      throw ConfigError(
          fmt::format("{}: found no muscle {}, expected one that the arm has", options.into, options.muscle));
    }
    muscle = static_cast<std::size_t>(found - arm->muscles.begin());
  }
  drive.fixed = options.fit.fixed();
  drive.bounds = options.fit.parameterBounds();
  Holdout holdout;
  MotorLog log;
  std::string log_sha256;
  {
    const CsvTable table = session.readTable("log", options.log, options.table.csv());
    log = readMotorLog(table);
    holdout = readHoldout(options.fit.holdout, table);
    log_sha256 = session.inputs().back().sha256;
  }
  std::vector<std::size_t> rows(log.rows());
  for (std::size_t i = 0; i < rows.size(); ++i) rows[i] = i;
  const double seconds = log.time.back() - log.time.front();
  const double block_s = options.fit.blockSeconds(seconds);
  const std::vector<Block> blocks = splitBlocks(log.time, log.session, block_s);
  std::vector<ParameterSpec> known;
  for (const char* name : {"R", "L", "K_E", "K_T", "J_M", "mu_M", "tau_CM", "eta", "tau_CG", "mu_G", "J_G"}) {
    known.push_back({name, ""});
  }
  requireKnownParameters(options.fit, known);
  if (options.common.dry_run) {
    fmt::print("would fit a {} to {} rows of {}; nothing was written\n", kind, log.rows(), options.log);
    return ExitCode::kDone;
  }
  std::optional<DriveFit> trained;
  DriveFit fit;
  std::string words = holdout.words;
  if (holdout.any()) {
    fit = fitDrive(log, drive, heldOutRows(holdout, blocks, rows));
  } else {
    fit = fitDrive(log, drive);
    Holdout fifth;
    fifth.fraction = 0.2;
    words = fmt::format("20 % of blocks of {:.3g} s, before the final fit to all rows", block_s);
    if (blocks.size() >= 5) trained = fitDrive(log, drive, heldOutRows(fifth, blocks, rows));
  }
  session.begin(options.common.seed.value_or(0));
  session.directory().write("config.resolved.yaml", resolvedOptions(*options.app));
  const FitSummary summary = summarise(kind, fit, trained, words);
  const Gearbox gearbox = gearboxOf(fit.theta, drive.ratio);
  const DriveResponse response = simulateDrive(log, motorOf(fit.theta), gearbox);
  const RunDirectory& directory = session.directory();
  FittedModel model = fittedModel(kind, "", summary.uncertainty);
  if (kind == "gearbox") model.settings["transmission_ratio"] = fmt::format("{}", drive.ratio);
  model.data_file = options.log;
  model.data_sha256 = log_sha256;
  model.data_rows = log.rows();
  directory.write("model.yaml", writeFittedModel(model));
  directory.write("parameters.csv", parametersCsv(summary));
  directory.write("correlation.csv", correlationCsv(summary));
  directory.write("response.csv", responseCsv(log, response));
  if (arm) writeInto(kind, options, *arm, muscle, fit, drive.ratio, summary.uncertainty, directory);
  session.finish(toJson(summary), terminalTable(summary));
  return ExitCode::kDone;
}

}  // namespace simgap
