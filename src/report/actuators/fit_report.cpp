#include "simgap/report/actuators/fit_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "fit_tables.h"
#include "simgap/core/csv.h"
#include "simgap/core/units.h"

namespace simgap {
namespace {

Json optionalNumber(const std::optional<double>& value) { return value ? numberOrNull(*value) : Json(nullptr); }

std::vector<std::string> allWarnings(const FitSummary& summary) {
  std::vector<std::string> all = summary.warnings;
  for (const std::string& sentence : summary.uncertainty.findings) {
    if (std::ranges::find(all, sentence) == all.end()) all.push_back(sentence);
  }
  return all;
}

}  // namespace

std::string valueText(double value, double sd) {
  if (!(sd > 0.0) || !std::isfinite(sd) || !std::isfinite(value) || value == 0.0) return fmt::format("{:.5g}", value);
  const int digits = static_cast<int>(std::floor(std::log10(std::abs(value))) - std::floor(std::log10(sd))) + 2;
  return fmt::format("{:.{}g}", value, std::clamp(digits, 2, 10));
}

Json toJson(const FitSummary& summary) {
  Json parameters = Json::array();
  for (const Estimate& e : summary.uncertainty.estimates) {
    parameters.push_back({{"name", e.name},
                          {"unit", e.unit},
                          {"value", numberOrNull(e.value)},
                          {"sd", e.fixed ? Json(nullptr) : numberOrNull(e.sd)},
                          {"ci95", {numberOrNull(e.lower95), numberOrNull(e.upper95)}},
                          {"at_bound", e.at_bound},
                          {"fixed", e.fixed},
                          {"identifiable", e.identifiable}});
  }
  Json comparison = Json::array();
  for (const ComparisonRow& row : summary.comparison) {
    comparison.push_back({{"model", row.model},
                          {"parameters", row.parameters},
                          {"mse", numberOrNull(row.mse)},
                          {"mse_heldout", optionalNumber(row.mse_heldout)},
                          {"bic", numberOrNull(row.bic)}});
  }
  Json transfer = Json::array();
  for (const TransferRow& row : summary.transfer) {
    transfer.push_back({{"file", row.file}, {"n", row.rows}, {"mse", numberOrNull(row.mse)}});
  }
  Json facts = Json::object();
  for (const auto& [name, text] : summary.facts) facts[name] = text;
  return {{"format", "simgap/" + summary.command + "/1"},
          {"model", summary.model},
          {"target", quantityName(summary.target, summary.target_unit)},
          {"parameters", parameters},
          {"mse", numberOrNull(summary.mse)},
          {"mse_heldout", optionalNumber(summary.mse_heldout)},
          {"heldout", summary.heldout},
          {"n", summary.n},
          {"n_effective", numberOrNull(summary.uncertainty.n_effective)},
          {"starts", {{"tried", summary.starts}, {"distinct_minima", summary.distinct_minima}}},
          {"comparison", comparison},
          {"chosen_by", summary.chosen_by},
          {"transfer", transfer},
          {"facts", facts},
          {"warnings", allWarnings(summary)}};
}

std::string parametersCsv(const FitSummary& summary) {
  CsvWriter csv({"name", "unit", "value", "sd", "ci95_lower", "ci95_upper", "at_bound", "fixed", "identifiable"});
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); };
  for (const Estimate& e : summary.uncertainty.estimates) {
    csv.add(e.name).add(e.unit).add(number(e.value)).add(number(e.sd)).add(number(e.lower95)).add(number(e.upper95));
    csv.add(e.at_bound ? "true" : "false").add(e.fixed ? "true" : "false");
    csv.add(e.identifiable ? "true" : "false").endRow();
  }
  return csv.text();
}

std::string correlationCsv(const FitSummary& summary) {
  std::vector<std::string> header{"parameter"};
  for (const Estimate& e : summary.uncertainty.estimates) header.push_back(e.name);
  CsvWriter csv(header);
  for (Eigen::Index i = 0; i < summary.uncertainty.correlation.rows(); ++i) {
    csv.add(summary.uncertainty.estimates[i].name);
    for (Eigen::Index j = 0; j < summary.uncertainty.correlation.cols(); ++j)
      csv.add(summary.uncertainty.correlation(i, j));
    csv.endRow();
  }
  return csv.text();
}

std::string terminalTable(const FitSummary& summary) {
  const Json result = toJson(summary);
  std::string text;
  if (summary.comparison.size() > 1) {
    text +=
        alignedTable(fitComparison(result)) + fmt::format("* chosen: {}; its parameters follow\n\n", summary.chosen_by);
  }
  text += alignedTable(fitParameters(result)) + fitAnswer(result) + "\n";
  for (const auto& fact : fitFacts(result).rows) text += fmt::format("{}: {}\n", fact[0], fact[1]);
  for (const std::string& warning : allWarnings(summary)) text += "note: " + warning + "\n";
  return text;
}

void writeFit(const FitSummary& summary, const FittedModel& model, const RunDirectory& directory) {
  directory.write("model.yaml", writeFittedModel(model));
  directory.write("parameters.csv", parametersCsv(summary));
  if (summary.uncertainty.correlation.size() > 0) directory.write("correlation.csv", correlationCsv(summary));
}

}  // namespace simgap
