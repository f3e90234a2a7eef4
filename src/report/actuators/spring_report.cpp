#include "simgap/report/actuators/spring_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap {
namespace {

using Eigen::Index;

constexpr double kLinear = 0.8;  // of the rest length: expansion up to which a shock cord is linear (000 eq. 2)

bool isAngular(const SpringReport& report) { return report.log.data.load_unit == "Nm"; }
std::string deflectionColumn(const SpringReport& report) {
  return isAngular(report) ? "deflection_rad" : "deflection_m";
}
std::string unitText(const SpringReport& report) { return isAngular(report) ? "rad" : "m"; }

std::vector<Index> shownRows(const SpringReport& report) {
  constexpr Index kMost = 3000;
  const Index count = report.log.data.rows.rows(), stride = std::max<Index>(1, count / kMost);
  std::vector<Index> rows;
  for (Index i = 0; i < count; i += stride) {
    if (report.log.data.keep[i]) rows.push_back(i);
  }
  return rows;
}

/// Measured force over deflection, some rows of the log, and each candidate at rest.
std::string forcesCsv(const SpringReport& report) {
  const ActuatorRows& rows = report.log.data.rows;
  CsvWriter csv({"series", deflectionColumn(report), report.log.effort_column});
  for (const Index i : shownRows(report)) csv.add("measured").add(rows.deflection[i]).add(rows.effort[i]).endRow();
  const double low = rows.deflection.minCoeff(), high = rows.deflection.maxCoeff();
  for (const SpringCandidate& c : report.comparison.candidates) {
    for (int k = 0; k <= 100; ++k) {
      const double x = low + (high - low) * k / 100.0;
      csv.add(c.name).add(x).add(c.fit.force(x, 0.0)).endRow();
    }
  }
  return csv.text();
}

/// What each candidate misses, over time and deflection.
std::string springErrorsCsv(const SpringReport& report) {
  const ActuatorRows& rows = report.log.data.rows;
  CsvWriter csv(
      {"series", rows.timed ? "time_s" : "row", deflectionColumn(report), "error_" + report.log.data.load_unit});
  for (const SpringCandidate& c : report.comparison.candidates) {
    for (const Index i : shownRows(report)) {
      const double error = c.fit.force(rows.deflection[i], rows.speed[i]) - rows.effort[i];
      csv.add(c.name).add(rows.time[i]).add(rows.deflection[i]).add(error).endRow();
    }
  }
  return csv.text();
}

FittedModel springModel(const SpringReport& report) {
  const SpringCandidate& chosen = report.comparison.chosen();
  FittedModel model = fittedModel("spring", chosen.fit.cord ? kCord : "", chosen.fit.uncertainty);
  const ActuatorRows& rows = report.log.data.rows;
  model.settings = {{"deflection_min", fmt::format("{}", rows.deflection.minCoeff())},
                    {"deflection_max", fmt::format("{}", rows.deflection.maxCoeff())}};
  model.data_file = report.log.file;
  model.data_sha256 = report.log_sha256;
  model.data_rows = chosen.fit.n;
  return model;
}

/// The arm with the fitted cord in one muscle. The rest length stays the arm's unless the log holds the cord's length.
ArmModel armWithCord(const SpringReport& report) {
  ArmModel arm = report.into->arm;
  ShockCord& cord = arm.muscles[report.into->muscle].shock_cord;
  const SpringFit& fit = report.comparison.chosen().fit;
  cord.stiffness = fit.theta[0];
  if (report.log.data.rows.timed) cord.damping = fit.theta[2];
  if (report.own_length) cord.rest_length = unloadedDeflection(fit).deflection;
  return arm;
}

/// Estimates as the arm's calibration knows them.
Uncertainty cordParameters(const SpringReport& report) {
  const SpringFit& fit = report.comparison.chosen().fit;
  Uncertainty known;
  for (const Estimate& e : fit.uncertainty.estimates) {
    if (e.name == "stiffness" || e.name == "damping") known.estimates.push_back(e);
  }
  const Unloaded rest = unloadedDeflection(fit);
  if (report.own_length) {
    known.estimates.push_back({.name = "rest_length", .unit = "m", .value = rest.deflection, .sd = rest.sd});
  }
  return known;
}

std::vector<std::string> springWarnings(const SpringReport& report) {
  std::vector<std::string> warnings = report.log.warnings;
  for (const ChannelSpikes& spikes : report.log.spikes) {
    warnings.push_back(standsAlone(spikes) + ": they were left out");
  }
  for (const ChannelSpikes& c : report.log.clipped) {
    warnings.push_back(fmt::format("{} sits at its limit in {} rows: they were left out", c.channel, c.rows.size()));
  }
  const double rest = unloadedDeflection(report.comparison.chosen().fit).deflection;
  const double expansion = report.log.data.rows.deflection.maxCoeff() / rest - 1.0;
  if (report.own_length && rest > 0.0 && expansion > kLinear) {
    warnings.push_back(fmt::format("the cord was expanded by {:.0f} % of its rest length: beyond 80 % it is not linear",
                                   100.0 * expansion));
  }
  if (!report.log.data.rows.timed) warnings.emplace_back("without time_s there is no damping: not fitted");
  return warnings;
}

}  // namespace

FitSummary summarise(const SpringReport& report) {
  FitSummary summary = summaryOf(report.comparison);
  summary.command = "fit-spring";
  summary.target = isAngular(report) ? "torque" : "force";
  summary.target_unit = report.log.data.load_unit;
  summary.warnings = springWarnings(report);
  const SpringFit& fit = report.comparison.chosen().fit;
  const Unloaded rest = unloadedDeflection(fit);
  if (std::isfinite(rest.deflection)) {
    summary.facts.emplace_back(report.own_length ? "rest length"
                               : fit.cord        ? "slack below"
                                                 : "no force at",
                               fmt::format("{}{} {}", valueText(rest.deflection, rest.sd),
                                           rest.sd > 0.0 ? fmt::format(" ± {:.2g}", rest.sd) : "", unitText(report)));
  }
  summary.transfer = report.transfer;
  return summary;
}

void writeSpringReport(const SpringReport& report, const RunDirectory& directory) {
  const FitSummary summary = summarise(report);
  writeFit(summary, springModel(report), directory);
  directory.write("forces.csv", forcesCsv(report));
  directory.write("errors.csv", springErrorsCsv(report));
  if (!report.into) return;
  const std::string& muscle = report.into->arm.muscles[report.into->muscle].name;
  directory.write("arm.yaml", writeArm(armWithCord(report)));
  directory.write("calibration_parameters.yaml", calibrationParameters(muscle, cordParameters(report)));
}

}  // namespace simgap
