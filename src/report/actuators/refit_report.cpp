#include "simgap/report/actuators/refit_report.h"

#include <cmath>

#include "simgap/core/units.h"
#include "simgap/report/log_predictions.h"

namespace simgap {

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
    summary.uncertainty.estimates.push_back({.name = p.name,
                                             .unit = p.unit,
                                             .value = p.value,
                                             .sd = p.sd,
                                             .at_bound = p.at_bound,
                                             .identifiable = std::isfinite(p.sd),
                                             .lower95 = p.value - half,
                                             .upper95 = p.value + half});
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

void writeRefit(const FitSummary& summary, const PreparedLog& log, const FittedModel& model, const LogRefit& refit,
                const RunDirectory& directory) {
  writeFit(summary, model, directory);
  directory.write("predictions.csv", predictionsCsv(log, {{"predicted", &refit.predicted}}));
}

}  // namespace simgap
