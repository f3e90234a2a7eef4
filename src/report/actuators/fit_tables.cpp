#include "fit_tables.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/json_numbers.h"
#include "simgap/core/units.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap {
namespace {

std::string targetUnit(const Json& result) { return unitTitle(splitUnit(result.at("target").get<std::string>()).unit); }

/// How the search went; empty without one over several starts.
std::string searchText(const Json& starts) {
  const long tried = wholeNumber(starts.at("tried"));
  if (tried <= 1) return {};
  return fmt::format("{} starts over the whole box, {} distinct local minima", tried,
                     wholeNumber(starts.at("distinct_minima")));
}

/// "RMS 0.01 A (300 rows)": the error on another log, one entry of `transfer`.
std::string transferText(const Json& transfer, const std::string& unit) {
  return fmt::format("RMS {:.4g} {} ({} rows)", std::sqrt(numberOf(transfer.at("mse"))), unit,
                     wholeNumber(transfer.at("n")));
}

/// By how much an error is smaller than the first model's.
std::string improvement(const Json& rows, const Json& row, const char* key) {
  const double from = numberOf(rows.front().at(key)), to = numberOf(row.at(key));
  if (&row == &rows.front() || !(from > 0.0) || !std::isfinite(to)) return "/";
  return fmt::format("{:.2f} %", 100.0 * (from - to) / from);
}

std::string noteOf(const Json& parameter) {
  if (parameter.at("fixed").get<bool>()) return "fixed";
  if (!parameter.at("identifiable").get<bool>()) return "not determined";
  return parameter.at("at_bound").get<bool>() ? "at bound" : "";
}

}  // namespace

Table fitComparison(const Json& result) {
  const Json& rows = result.at("comparison");
  Table table{fmt::format("Models on the same rows (MSE in {}², * chosen{})",
                          splitUnit(result.at("target").get<std::string>()).unit,
                          result.contains("chosen_by") ? ": " + result["chosen_by"].get<std::string>() : ""),
              {"model", "par.", "MSE", "held-out MSE", "improvement", "held-out", "BIC"},
              {}};
  for (const Json& row : rows) {
    const std::string name = row.at("model");
    table.rows.push_back({name + (name == result.at("model") ? " *" : ""), row.at("parameters").dump(),
                          numberText(row.at("mse"), "{:.5g}"), numberText(row.at("mse_heldout"), "{:.5g}"),
                          improvement(rows, row, "mse"), improvement(rows, row, "mse_heldout"),
                          numberText(row.at("bic"), "{:.1f}")});
  }
  return table;
}

Table fitParameters(const Json& result) {
  Table table{"Parameters", {"parameter", "unit", "value", "sd", "95 % interval", ""}, {}};
  for (const Json& p : result.at("parameters")) {
    const bool fixed = p.at("fixed");
    const double value = numberOf(p.at("value")), sd = numberOf(p.at("sd"));
    const double lower = numberOf(p.at("ci95").at(0)), upper = numberOf(p.at("ci95").at(1));
    const bool interval = !fixed && std::isfinite(lower) && std::isfinite(upper);
    const std::string unit = p.at("unit"), shown = fixed ? numberText(p.at("value"), "{:.6g}") : valueText(value, sd);
    table.rows.push_back({p.at("name"), unit == "1" ? "-" : unitTitle(unit), std::isfinite(value) ? shown : "-",
                          numberText(p.at("sd"), "{:.2g}"),
                          interval ? fmt::format("{} … {}", valueText(lower, sd), valueText(upper, sd)) : "-",
                          noteOf(p)});
  }
  return table;
}

std::string fitAnswer(const Json& result) {
  const std::string unit = targetUnit(result);
  const double rms = std::sqrt(numberOf(result.at("mse"))), heldout = std::sqrt(numberOf(result.at("mse_heldout")));
  return fmt::format("{} predicts {} with an RMS error of {:.4g} {}", result.at("model").get<std::string>(),
                     splitUnit(result.at("target").get<std::string>()).stem, rms, unit) +
         (std::isfinite(heldout) ? fmt::format(", and {:.4g} {} on rows it was not fitted to.", heldout, unit)
                                 : "; only rows it was not fitted to can show what that is worth.");
}

Table fitFacts(const Json& result) {
  Table table{"Further results", {"", ""}, {}};
  table.rows.push_back({"rows", fmt::format("{}, worth {:.0f} independent ones", wholeNumber(result.at("n")),
                                            numberOf(result.at("n_effective")))});
  if (result.at("mse_heldout").is_number()) table.rows.push_back({"held out", result.at("heldout")});
  if (const std::string search = searchText(result.at("starts")); !search.empty()) {
    table.rows.push_back({"search", search});
  }
  for (const auto& [name, text] : result.at("facts").items()) table.rows.push_back({name, text});
  for (const Json& row : result.at("transfer")) {
    table.rows.push_back({"on " + row.at("file").get<std::string>(), transferText(row, targetUnit(result))});
  }
  return table;
}

std::string axisTitle(const std::string& column) {
  UnitName name = splitUnit(column);
  std::ranges::replace(name.stem, '_', ' ');
  return name.unit.empty() ? name.stem : fmt::format("{} [{}]", name.stem, unitTitle(name.unit));
}

}  // namespace simgap
