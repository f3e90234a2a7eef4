#include <limits>

#include "simgap/report/decode/decode_report.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::decode_run {
namespace {

/// 1 up, 0 down, a gap where there is none.
std::vector<double> stateValues(const CsvTable& table, const char* column) {
  std::vector<double> values;
  for (const std::string& state : table.text(column)) {
    values.push_back(state == "up" ? 1.0 : state == "down" ? 0.0 : std::numeric_limits<double>::quiet_NaN());
  }
  return values;
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"What was decoded", decodeRunAnswer(result), {}};
  const CsvTable table = files.table("decoded.csv");
  const std::vector<double> time = numbersOf(table, "time_s");
  std::vector<Series> lines = {thinned({"probability of up", time, numbersOf(table, "probability_up")})};
  lines.push_back(thinned({"state", time, stateValues(table, "state")}));
  if (table.has("label")) {
    Series asked = thinned({"asked for", time, stateValues(table, "label"), Series::Style::kDashed});
    asked.faint = true;
    lines.push_back(asked);
  }
  Chart chart = lineChart("Probability and state", {"time [s]"}, {"up"}, lines);
  chart.note = "The state follows when the probability of the other one exceeds the threshold.";
  chart.wide = true;
  makeZoomable(chart);
  page.add(chart);
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/decode-run/1", make};

}  // namespace simgap::pages::decode_run
