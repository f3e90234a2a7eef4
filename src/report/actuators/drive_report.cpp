#include "simgap/report/actuators/drive_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/model/arm/arm_yaml.h"

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
                               {"tau_CG", "gearbox.coulomb_friction_Nm"},
                               {"stiffness", "shock_cord.stiffness_N_m"},
                               {"damping", "shock_cord.damping_Ns_m"},
                               {"rest_length", "shock_cord.rest_length_m"}};

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

std::string responseCsv(const DriveReport& report) {
  const MotorLog& log = report.log;
  const std::vector<double>& theta = report.fit.fit.theta;
  const DriveResponse response = simulateDrive(log, motorOf(theta), gearboxOf(theta, report.ratio));
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

/// "simulated velocity": its error, and the share of what was measured that it is.
std::string channelText(const DriveChannel& channel, const std::optional<double>& heldout) {
  return fmt::format("RMS {:.4g} {}{}, {:.1f} % of the measurement's spread", channel.rms, channel.unit,
                     heldout ? fmt::format(" (held out {:.4g})", *heldout) : "", 100.0 * channel.rms / channel.spread);
}

/// The arm with the fitted drive in one muscle; the supply voltage, which no fit knows, stays the arm's.
ArmModel armWithDrive(const DriveReport& report) {
  ArmModel arm = report.into->arm;
  Muscle& muscle = arm.muscles[report.into->muscle];
  const std::vector<double>& theta = report.fit.fit.theta;
  if (report.kind == "motor") {
    const double supply = muscle.motor.supply_voltage;
    muscle.motor = motorOf(theta);
    muscle.motor.supply_voltage = supply;
  } else {
    muscle.gearbox = gearboxOf(theta, report.ratio);
  }
  return arm;
}

FittedModel driveModel(const DriveReport& report, const Uncertainty& uncertainty) {
  FittedModel model = fittedModel(report.kind, "", uncertainty);
  if (report.kind == "gearbox") model.settings["transmission_ratio"] = fmt::format("{}", report.ratio);
  model.data_file = report.log_file;
  model.data_sha256 = report.log_sha256;
  model.data_rows = report.log.rows();
  return model;
}

}  // namespace

std::string calibrationParameters(const std::string& muscle, const Uncertainty& uncertainty) {
  std::string text =
      "# For the `parameters:` of a calibration config; the covariance stands in model.yaml.\nparameters:\n";
  for (const Estimate& e : uncertainty.estimates) {
    const auto key = std::ranges::find_if(kArmKeys, [&](const ArmKey& k) { return e.name == k.parameter; });
    if (key == std::end(kArmKeys) || e.fixed || !std::isfinite(e.sd) || e.sd <= 0.0) continue;
    text += fmt::format("  - {{pattern: \"muscles.{}.{}\", step: {:.6g}, prior_sd: {:.6g}}}\n", muscle, key->key, e.sd,
                        e.sd);
  }
  return text;
}

FitSummary summarise(const DriveReport& report) {
  const DriveFit &fit = report.fit.fit, &judged = report.fit.judged();
  const DriveChannel& target = fit.channels.front();
  FitSummary summary;
  summary.command = "fit-" + report.kind;
  summary.model = report.kind;
  summary.target = target.name;
  summary.target_unit = target.unit;
  summary.uncertainty = partOf(fit.uncertainty, report.kind);
  summary.mse = target.rms * target.rms;
  if (judged.channels.front().rms_heldout) {
    summary.mse_heldout = std::pow(*judged.channels.front().rms_heldout, 2);
    summary.heldout = report.fit.heldout;
  }
  summary.n = fit.rows;
  summary.starts = fit.starts;
  summary.distinct_minima = fit.distinct_minima;
  summary.comparison.push_back({report.kind, 0, summary.mse, summary.mse_heldout, 0.0});
  summary.warnings = fit.warnings;
  for (std::size_t c = 0; c < fit.channels.size(); ++c) {
    summary.facts.emplace_back("simulated " + fit.channels[c].name,
                               channelText(fit.channels[c], judged.channels[c].rms_heldout));
  }
  return summary;
}

void writeDriveReport(const DriveReport& report, const RunDirectory& directory) {
  const FitSummary summary = summarise(report);
  directory.write("model.yaml", writeFittedModel(driveModel(report, summary.uncertainty)));
  directory.write("parameters.csv", parametersCsv(summary));
  directory.write("correlation.csv", correlationCsv(summary));
  directory.write("response.csv", responseCsv(report));
  if (!report.into) return;
  const std::string& muscle = report.into->arm.muscles[report.into->muscle].name;
  directory.write("arm.yaml", writeArm(armWithDrive(report)));
  directory.write("calibration_parameters.yaml", calibrationParameters(muscle, summary.uncertainty));
}

}  // namespace simgap
