#include <algorithm>
#include <cmath>

#include "simgap/core/statistics.h"
#include "simgap/report/html/result_page.h"
#include "simgap/report/runs/run_comparison.h"

namespace simgap::pages::compare {
namespace {

/// A parameter's value in every run over the common one.
Chart valuesChart(const Json& parameter) {
  const std::string unit = unitTitle(parameter.at("unit").get<std::string>());
  std::vector<IntervalRow> rows;
  for (const Json& run : parameter.at("runs")) {
    const double value = numberOf(run.at("value")), half = kNormalQuantile * numberOf(run.at("sd"));
    rows.push_back({cellText(run.at("run")), value, value - half, value + half});
  }
  rows.push_back({"common", numberOf(parameter.at("common")), numberOf(parameter.at("common_ci95")[0]),
                  numberOf(parameter.at("common_ci95")[1]), "common", 1});
  return intervalChart(cellText(parameter.at("name")) + ", run by run", {"value [" + unit + "]"}, rows);
}

Page make(const ResultFiles& files) {
  constexpr std::size_t kCharts = 6;
  const Json& result = files.result();
  Page page{"Runs compared", comparisonAnswer(result), {}};
  for (const Json& warning : result.at("warnings")) page.notes.push_back(cellText(warning));
  std::vector<const Json*> parameters;
  for (const Json& p : result.at("parameters")) parameters.push_back(&p);
  std::ranges::stable_sort(parameters, {}, [](const Json* p) { return numberOf(p->at("p_adjusted")); });
  for (std::size_t i = 0; i < std::min(kCharts, parameters.size()); ++i) page.add(valuesChart(*parameters[i]));
  page.addSection("All parameters");
  page.add(recordTable("Pooled over the runs", result.at("parameters"),
                       {"name", "unit", "common", "common_ci95", "scatter", "scatter_ci95", "p_adjusted", "verdict"}));
  page.addSection("Errors");
  Table errors{"Errors of every run", {"error"}, {}};
  for (const Json& run : result.at("runs")) errors.header.push_back(cellText(run.at("name")));
  for (const Json& error : result.at("errors")) {
    errors.rows.push_back({cellText(error.at("name"))});
    for (const Json& value : error.at("values")) errors.rows.back().push_back(numberText(value, "{:.5g}"));
  }
  page.add(std::move(errors));
  if (!result.at("causes").empty()) {
    page.addSection("Causes");
    Table causes{"Which run found which cause", {"cause", "run", "gain [%]", "magnitude"}, {}};
    for (const Json& cause : result.at("causes")) {
      for (const Json& run : cause.at("runs")) {
        causes.rows.push_back({cellText(cause.at("cause")), cellText(run.at("run")),
                               numberText(run.at("gain_heldout_percent"), "{:.1f}"), cellText(run.at("magnitude"))});
      }
    }
    page.add(std::move(causes));
  }
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/compare/1", make};

}  // namespace simgap::pages::compare
