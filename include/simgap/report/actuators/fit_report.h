/// \file
/// The results of the `fit-*` commands as JSON (docs/formats.md), CSV and a table for the terminal.
#pragma once

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
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
  std::vector<TransferRow> transfer;
  std::vector<std::string> warnings;
  std::vector<std::pair<std::string, std::string>> facts;  ///< further results: name and text
};

Json toJson(const FitSummary& summary);
std::string terminalTable(const FitSummary& summary);

/// model.yaml, parameters.csv and, where there is one, correlation.csv.
void writeFit(const FitSummary& summary, const FittedModel& model, const RunDirectory& directory);

/// A number with as many digits as its standard deviation supports.
std::string valueText(double value, double sd);

}  // namespace simgap
