#include "fit_tables.h"

#include <fmt/format.h>

#include <cmath>

#include "simgap/core/units.h"
#include "simgap/report/actuators/fit_report.h"

namespace simgap {
namespace {

/// By how much an error is smaller than the first model's.
std::string improvement(const Json& rows, const Json& row, const char* key) {
  const double from = numberOf(rows.front().at(key)), to = numberOf(row.at(key));
  if (&row == &rows.front() || !std::isfinite(from - to)) return "/";
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
  Table table{fmt::format("Models on the same rows (MSE in {}², * lowest BIC)",
                          splitUnit(result.at("target").get<std::string>()).unit),
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
    table.rows.push_back(
        {p.at("name"), unit == "1" ? "-" : unit, std::isfinite(value) ? shown : "-", numberText(p.at("sd"), "{:.2g}"),
         interval ? fmt::format("{} … {}", valueText(lower, sd), valueText(upper, sd)) : "-", noteOf(p)});
  }
  return table;
}

std::string searchText(const Json& starts) {
  const long tried = starts.at("tried");
  if (tried <= 1) return {};
  return fmt::format("{} starts over the whole box, {} distinct local minima", tried,
                     starts.at("distinct_minima").get<long>());
}

std::string transferText(const Json& transfer, const std::string& unit) {
  return fmt::format("RMS {:.4g} {} ({} rows)", std::sqrt(numberOf(transfer.at("mse"))), unit,
                     transfer.at("n").get<long>());
}

}  // namespace simgap
