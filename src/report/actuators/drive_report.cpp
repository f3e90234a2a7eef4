#include "simgap/report/actuators/drive_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/model/arm/arm_yaml.h"
#include "simgap/report/table.h"

namespace simgap {
namespace {

/// The estimates that belong to the kind: a motor's, or a gearbox's.
Uncertainty partOf(const Uncertainty& all, const std::string& kind) {
  return kind == "motor" ? partOf(all, 0, kMotorParameters) : partOf(all, kMotorParameters, kDriveParameters);
}

std::string responseCsv(const DriveReport& report) {
  const MotorLog& log = report.log;
  const std::vector<double>& theta = report.fit.fit.theta;
  const DriveResponse response =
      simulateDrive(log, motorOf(theta), gearboxOf(theta, report.ratio), report.fit.fit.delays, report.fit.fit.extent);
  const bool whole = report.fit.fit.extent == DriveExtent::kWhole;  // or else the velocity is the measured one
  std::vector<std::string> header{"time_s"};
  if (whole) header.emplace_back("velocity_simulated_rad_s");
  header.emplace_back("current_simulated_A");
  if (!log.velocity.empty()) header.emplace_back("velocity_measured_rad_s");
  if (!log.current.empty()) header.emplace_back("current_measured_A");
  CsvWriter csv(header);
  for (std::size_t i = 0; i < log.rows(); ++i) {
    csv.add(log.time[i]);
    if (whole) csv.add(response.velocity[i]);
    csv.add(response.current[i]);
    if (!log.velocity.empty()) csv.add(log.velocity[i]);
    if (!log.current.empty()) csv.add(log.current[i]);
    csv.endRow();
  }
  return csv.text();
}

/// "simulated velocity": its error, and the share of what was measured that it is.
std::string channelText(const DriveChannel& channel, const std::optional<double>& heldout) {
  return fmt::format("RMS {:.4g} {}{}, {:.1f} % of the measurement's spread", channel.rms, unitTitle(channel.unit),
                     heldout ? fmt::format(" (held out {:.4g})", *heldout) : "", 100.0 * channel.rms / channel.spread);
}

/// The motor that goes into an arm: what was not found stays as it is there.
Motor motorInto(const DriveReport& report) {
  const Motor& own = report.into->arm.muscles[report.into->muscle].motor;
  const std::array kept = {own.resistance, own.inductance,       own.back_emf_constant, own.torque_constant,
                           own.inertia,    own.viscous_friction, own.coulomb_friction};
  std::vector<double> theta = report.fit.fit.theta;
  for (std::size_t i = 0; i < kept.size(); ++i) {
    if (std::isnan(report.fit.fit.uncertainty.estimates[i].value)) theta[i] = kept[i];
  }
  return motorOf(theta);
}

FittedModel driveModel(const DriveReport& report, const Uncertainty& uncertainty) {
  FittedModel model = fittedModel(report.kind, "", uncertainty);
  if (report.kind == "gearbox") model.settings["transmission_ratio"] = fmt::format("{}", report.ratio);
  for (const Estimate& e : report.fit.fit.uncertainty.estimates) {  // predictions of this rig's logs need them
    if (e.name.ends_with("_delay") && std::isfinite(e.value) && e.value != 0.0) {
      model.settings[e.name + "_s"] = fmt::format("{:.9g}", e.value);
    }
  }
  model.data_file = report.log_file;
  model.data_sha256 = report.log_sha256;
  model.data_rows = report.log.rows();
  return model;
}

}  // namespace

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
  if (const std::vector<std::string> unknown = notFound(summary.uncertainty); report.into && !unknown.empty()) {
    summary.warnings.push_back(fmt::format("arm.yaml keeps the arm's own {}", fmt::join(unknown, ", ")));
  }
  for (std::size_t c = 0; c < fit.channels.size(); ++c) {
    summary.facts.emplace_back("simulated " + fit.channels[c].name,
                               channelText(fit.channels[c], judged.channels[c].rms_heldout));
  }
  for (const FittedDelay& delay : fit.fitted_delays) {
    const std::string size = std::isfinite(delay.sd)
                                 ? fmt::format("{:.3g} ± {:.2g} ms", 1e3 * delay.seconds, 1e3 * delay.sd)
                                 : fmt::format("{:.3g} ms, the most that is tried,", 1e3 * delay.seconds);
    summary.facts.emplace_back(delay.channel,
                               fmt::format("{} after {} ({:.2f} rows)", size, delay.against, delay.rows));
  }
  return summary;
}

void writeDriveReport(const DriveReport& report, const RunDirectory& directory) {
  const FitSummary summary = summarise(report);
  writeFit(summary, driveModel(report, summary.uncertainty), directory);
  directory.write("response.csv", responseCsv(report));
  if (!report.into) return;
  const std::string& muscle = report.into->arm.muscles[report.into->muscle].name;
  const std::vector<double>& theta = report.fit.fit.theta;
  directory.write("arm.yaml",
                  writeArm(report.kind == "motor" ? withMotor(*report.into, motorInto(report))
                                                  : withGearbox(*report.into, gearboxOf(theta, report.ratio))));
  directory.write("calibration_parameters.yaml", calibrationParameters(muscle, summary.uncertainty));
}

}  // namespace simgap
