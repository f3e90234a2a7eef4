#include "simgap/report/actuators/pam_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "simgap/core/csv.h"

namespace simgap {
namespace {

/// Every so many rows are shown.
std::size_t muscleStride(const PamLog& log) { return std::max<std::size_t>(1, log.rows() / 1500); }

Pam unboundedMuscle(const PamCandidate& candidate) {
  Pam muscle = candidate.fit.muscle();
  muscle.lowest = -1.0, muscle.highest = 1.0;
  return muscle;
}

/// The pressures of the log where they are set in steps, else some that span them, rising [Pa].
std::vector<double> pressureLevels(const PamLog& log) {
  constexpr double kStep = 1e4;
  constexpr std::size_t kMost = 12;
  std::set<double> steps;
  for (const double pressure : log.pressure) steps.insert(kStep * std::round(pressure / kStep));
  if (steps.size() <= kMost) return {steps.begin(), steps.end()};
  std::vector<double> sorted(log.pressure), levels;
  std::ranges::sort(sorted);
  for (const double q : {0.02, 0.2, 0.4, 0.6, 0.8, 0.98}) {
    levels.push_back(sorted[static_cast<std::size_t>(q * static_cast<double>(sorted.size() - 1))]);
  }
  return levels;
}

/// Measured and predicted force over contraction: some rows of the log, and the chosen model at all pressures.
std::string forcesCsv(const PamCandidate& chosen, const PamLog& log) {
  CsvWriter csv({"series", "contraction", "force_N"});
  // Of two muscles that oppose each other no single one's force was measured.
  for (std::size_t i = 0; !log.opposed() && i < log.rows(); i += muscleStride(log)) {
    csv.add("measured").add(log.contraction[i]).add(log.force[i]).endRow();
  }
  const auto [low, high] = std::ranges::minmax(log.contraction);
  const Pam muscle = unboundedMuscle(chosen);
  for (const double pressure : pressureLevels(log)) {
    for (int i = 0; i <= 60; ++i) {
      const double eps = low + (high - low) * i / 60.0;
      const auto f = muscle.force(pressure, eps);
      if (f) csv.add(fmt::format("{} at {:.0f} kPa", chosen.name, 1e-3 * pressure)).add(eps).add(*f).endRow();
    }
  }
  return csv.text();
}

std::string forceErrorsCsv(const std::vector<PamCandidate>& candidates, const PamLog& log) {
  CsvWriter csv({"series", "force_N", "error_N"});
  for (const PamCandidate& c : candidates) {
    const Pam muscle = unboundedMuscle(c);
    for (std::size_t i = 0; i < log.rows(); i += muscleStride(log)) {
      csv.add(c.name).add(log.force[i]).add(predictedForce(muscle, log, i) - log.force[i]).endRow();
    }
  }
  return csv.text();
}

FittedModel muscleModel(const PamReport& report) {
  const PamCandidate& chosen = report.comparison.chosen();
  FittedModel model = fittedModel("pam", chosen.name, chosen.fit.uncertainty);
  const auto [low, high] = std::ranges::minmax(report.log.contraction);
  model.settings = {{"contraction_min", fmt::format("{}", low)}, {"contraction_max", fmt::format("{}", high)}};
  model.data_file = report.log.file;
  model.data_sha256 = report.log_sha256;
  model.data_rows = report.log.rows();
  return model;
}

}  // namespace

FitSummary summarise(const PamReport& report) {
  const PamCandidate& chosen = report.comparison.chosen();
  FitSummary summary = summaryOf(report.comparison);
  summary.command = "fit-pam";
  summary.target = "force";
  summary.target_unit = "N";
  summary.warnings = chosen.fit.warnings;
  for (const ChannelSpikes& spikes : report.log.spikes) {
    summary.warnings.push_back(standsAlone(spikes) + ": put right by what lies beside them");
  }
  // Geometry demands b = -2 a as well (002 eq. 12): far from that a and c are those of no braid.
  const double tied = chosen.fit.theta[1] / (-2.0 * chosen.fit.theta[0]);
  const auto geometry = geometryOf(chosen.fit.theta[0], chosen.fit.theta[2]);
  if (geometry && tied > 0.5 && tied < 2.0) {
    summary.facts.emplace_back("geometry of a and c",
                               fmt::format("diameter {:.1f} mm, braid angle {:.1f} deg", 1e3 * geometry->diameter,
                                           geometry->angle * 180.0 / std::numbers::pi));
  }
  if (report.log.opposed()) {
    summary.facts.emplace_back("muscles", "two that are alike, from the difference of their forces");
  }
  if (report.maker) {
    summary.facts.emplace_back(
        "a, b, c", fmt::format("from {} (RMS {:.3g} N there)", report.maker_file, std::sqrt(report.maker->mse)));
  }
  summary.transfer = report.transfer;
  return summary;
}

void writePamReport(const PamReport& report, const RunDirectory& directory) {
  const FitSummary summary = summarise(report);
  writeFit(summary, muscleModel(report), directory);
  directory.write("forces.csv", forcesCsv(report.comparison.chosen(), report.log));
  directory.write("errors.csv", forceErrorsCsv(report.comparison.candidates, report.log));
}

}  // namespace simgap
