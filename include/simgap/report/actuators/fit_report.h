/// \file
/// The results of the `fit-*` commands as JSON (docs/formats.md), CSV and a table for the terminal.
#pragma once

#include <Eigen/Core>
#include <cmath>
#include <optional>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/fit/actuators/fit_comparison.h"
#include "simgap/model/actuator/fitted_model.h"
#include "simgap/optimize/uncertainty.h"

namespace simgap {

/// One line of a comparison of models on the same data (003 table 2).
struct ComparisonRow {
  std::string model;
  std::size_t parameters = 0;
  double mse = 0.0;
  std::optional<double> mse_heldout;
  double bic = 0.0;
};

/// The mean squared error of the chosen model on another log.
struct TransferRow {
  std::string file;
  std::size_t rows = 0;
  double mse = 0.0;
};

/// What every fit reports, whatever it fitted.
struct FitSummary {
  std::string command;      ///< "fit-friction"
  std::string model;        ///< what was fitted, or the best of several
  std::string target;       ///< what the error is of: "motor_current"
  std::string target_unit;  ///< "A"
  Uncertainty uncertainty;
  double mse = 0.0;  ///< [target_unit^2]
  std::optional<double> mse_heldout;
  std::string heldout;  ///< how it was held out, in words
  std::size_t n = 0;
  std::size_t starts = 0;
  std::size_t distinct_minima = 0;
  std::vector<ComparisonRow> comparison;
  std::string chosen_by;  ///< why the model was chosen, of several: "lowest BIC"
  std::vector<TransferRow> transfer;
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, std::string>> facts;  ///< further results: name and text
};

/// What a comparison of models says, whatever they model.
template <typename Fit>
FitSummary summaryOf(const FitComparison<Fit>& comparison) {
  const FitCandidate<Fit>& chosen = comparison.chosen();
  FitSummary summary;
  summary.model = chosen.name;
  summary.uncertainty = chosen.fit.uncertainty;
  summary.mse = chosen.fit.mse;
  summary.mse_heldout = chosen.mse_heldout;
  summary.heldout = comparison.heldout;
  summary.chosen_by = comparison.chosen_by;
  summary.n = chosen.fit.n;
  summary.starts = chosen.fit.starts;
  summary.distinct_minima = chosen.fit.distinct_minima;
  const double n = chosen.fit.uncertainty.n_effective;
  for (const FitCandidate<Fit>& c : comparison.candidates) {
    summary.comparison.push_back({c.name, c.fit.parameters, c.fit.mse, c.mse_heldout,
                                  n * std::log(c.fit.mse) + static_cast<double>(c.fit.parameters) * std::log(n)});
  }
  return summary;
}

Json toJson(const FitSummary& summary);
std::string terminalTable(const FitSummary& summary);

/// model.yaml, parameters.csv and, where there is one, correlation.csv.
void writeFit(const FitSummary& summary, const FittedModel& model, const RunDirectory& directory);

/// A number with as many digits as its standard deviation supports.
std::string valueText(double value, double sd);

}  // namespace simgap
