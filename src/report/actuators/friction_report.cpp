#include "simgap/report/actuators/friction_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "friction_tables.h"
#include "simgap/core/csv.h"
#include "simgap/core/units.h"
#include "simgap/report/table.h"

namespace simgap {
namespace {

std::string comparisonCsv(const FrictionReport& report) {
  CsvWriter csv({"model", "parameters", "mse", "mse_heldout", "improvement_percent", "bic", "n_effective"});
  const double first = report.laws.fits.front().mse;
  for (const FrictionFit& fit : report.laws.fits) {
    csv.add(fit.law->name).add(static_cast<double>(fit.parameters)).add(fit.mse);
    csv.add(fit.mse_heldout ? fmt::format("{}", *fit.mse_heldout) : "");
    csv.add(100.0 * (first - fit.mse) / first).add(fit.bic).add(fit.uncertainty.n_effective).endRow();
  }
  return csv.text();
}

std::string profileCsv(const FrictionReport& report) {
  CsvWriter csv({"model", "v_s", "delta", "mse"});
  for (const FrictionFit& fit : report.laws.fits) {
    if (fit.profile.axes.size() != 2) continue;
    for (std::size_t i = 0; i < fit.profile.cost.size(); ++i) {
      const std::vector<double> at = fit.profile.at(i);
      csv.add(fit.law->name).add(at[0]).add(at[1]);
      csv.add(fit.profile.cost[i] / static_cast<double>(fit.n)).endRow();
    }
  }
  return csv.text();
}

std::string minimaCsv(const FrictionReport& report) {
  CsvWriter csv({"model", "rank", "v_s", "delta", "mse"});
  for (const FrictionFit& fit : report.laws.fits) {
    for (std::size_t m = 0; m < fit.minima.size(); ++m) {
      const SeparableMinimum& minimum = fit.minima[m];
      csv.add(fit.law->name).add(static_cast<double>(m + 1));
      csv.add(minimum.p.empty() ? "" : fmt::format("{}", minimum.p[0]));
      csv.add(minimum.p.empty() ? "" : fmt::format("{}", minimum.p[1]));
      csv.add(minimum.linear.cost / static_cast<double>(fit.n)).endRow();
    }
  }
  return csv.text();
}

std::string seriesCsv(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  const std::vector<TimeSample> samples = timeSamples(report.rows());
  std::vector<std::string> header{"time_s", "row", "measured"};
  for (const FrictionFit& fit : report.laws.fits) header.emplace_back(fit.law->name);
  CsvWriter csv(header);
  for (const TimeSample& sample : samples) {
    csv.add(data.time[sample.index]).add(static_cast<double>(data.row[sample.index] + 1));
    csv.add(sample.measured);
    for (const double value : sample.predicted) csv.add(value);
    csv.endRow();
  }
  return csv.text();
}

}  // namespace

FitSummary summarise(const FrictionReport& report) {
  const FrictionData& data = *report.data;
  const FrictionFit& best = report.best();
  FitSummary summary;
  summary.command = "fit-friction";
  summary.model = best.law->name;
  summary.chosen_by = "lowest BIC";
  summary.target = report.options.predict_load ? "external_load" : data.effort_name;
  summary.target_unit = report.options.predict_load ? data.load_unit : data.effort_unit;
  summary.uncertainty = best.uncertainty;
  summary.mse = best.mse;
  summary.mse_heldout = best.mse_heldout;
  summary.heldout = report.laws.heldout;
  summary.n = best.n;
  summary.starts = best.starts;
  summary.distinct_minima = best.minima.size();
  for (const FrictionFit& fit : report.laws.fits) {
    summary.comparison.push_back({std::string(fit.law->name), fit.parameters, fit.mse, fit.mse_heldout, fit.bic});
  }
  summary.transfer = report.transfer;
  summary.warnings = data.warnings;
  summary.warnings.insert(summary.warnings.end(), report.laws.left_out.begin(), report.laws.left_out.end());
  summary.warnings.insert(summary.warnings.end(), best.warnings.begin(), best.warnings.end());
  if (data.log_rows != data.rows()) {
    summary.facts.emplace_back("rows left out", fmt::format("{} of {} (before the first motion, at reversals, held out "
                                                            "or not chosen)",
                                                            data.log_rows - data.rows(), data.log_rows));
  }
  if (data.dead_band > 0.0) {
    summary.facts.emplace_back("direction held", fmt::format("within ±{:.3g} {}, {} reversals", data.dead_band,
                                                             unitTitle(data.velocity_unit), data.reversals));
  }
  for (const std::string& channel : data.derived) {
    summary.facts.emplace_back(channel, fmt::format("worked out, zero-phase smoothing of {:.3g} Hz", data.bandwidth));
  }
  for (auto& fact : requirementSentences(report)) summary.facts.push_back(std::move(fact));
  return summary;
}

void writeFrictionReport(const FrictionReport& report, const std::string& log_sha256, const RunDirectory& directory) {
  const FrictionData& data = *report.data;
  const FrictionFit& best = report.best();
  FittedModel model = fittedModel("friction", std::string(best.law->name), best.uncertainty);
  model.settings = {{"effort", data.effort_name},
                    {"effort_unit", data.effort_unit},
                    {"load_unit", data.load_unit},
                    {"predicts", report.options.predict_load ? "torque" : "effort"},
                    {quantityName("dead_band", data.velocity_unit), fmt::format("{}", data.dead_band)}};
  if (report.ratio) model.settings["transmission_ratio"] = fmt::format("{}", *report.ratio);
  model.data_file = data.file;
  model.data_sha256 = log_sha256;
  model.data_rows = data.log_rows;
  const FitSummary summary = summarise(report);
  writeFit(summary, model, directory);
  directory.write("comparison.csv", comparisonCsv(report));
  directory.write("minima.csv", minimaCsv(report));
  directory.write("profile.csv", profileCsv(report));
  directory.write("series.csv", seriesCsv(report));
  directory.write("maps.csv", mapsCsv(report));
  directory.write("friction.csv", frictionCsv(report));
  directory.write("histograms.csv", histogramsCsv(report));
  directory.write("models.csv", modelsCsv(report));
  if (!report.options.predict_load) directory.write("curves.csv", curvesCsv(report));
  if (!report.requirements.empty()) directory.write("requirements.csv", requirementsCsv(report));
}

}  // namespace simgap
