#include <fmt/format.h>

#include "report/diagnosis/separation_tables.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::separate {
namespace {

Chart countsChart(const Json& result) {
  std::vector<double> count, chosen, random;
  for (std::size_t k = 0; k < result.at("smallest").size(); ++k) {
    count.push_back(static_cast<double>(k + 1));
    chosen.push_back(numberOf(result.at("smallest")[k]));
    random.push_back(numberOf(result.at("smallest_random")[k]));
  }
  Chart chart = lineChart("What so many poses are expected to tell", {"poses"}, {"smallest log odds of any pair"},
                          {{"these", count, chosen}, {"random ones", count, random, Series::Style::kDashed}});
  chart.note = "3: odds of 20 to 1.";
  return chart;
}

Chart protocolChart(const Json& result) {
  std::vector<std::string> names;
  std::vector<double> odds;
  for (const Json& p : result.at("protocols")) {
    const std::string speed = fmt::format("speed x {:g}", numberOf(p.at("speed")));
    names.push_back(p.contains("motion") ? cellText(p.at("motion")) + ", " + speed
                                         : fmt::format("{}, load x {:g}", speed, numberOf(p.at("load"))));
    odds.push_back(numberOf(p.at("smallest_log_odds")));
  }
  return barChart("What each motion is expected to tell", names, {"smallest log odds of any pair"},
                  {{"log odds", {}, odds}});
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"simgap design --separate", separationAnswer(result), {}};
  const bool of_motions = result.value("of", "") == "motions", of_protocols = result.contains("protocols");
  page.verdict = {PageVerdict::Level::kGood, "designed", "Record it, then ask the same models, with nothing refitted.",
                  of_motions     ? "simgap intervene RUN --motions RECORDED"
                  : of_protocols ? "simgap intervene RUN --log RECORDED"
                                 : "simgap intervene RUN --poses RECORDED"};
  page.add(of_protocols ? protocolChart(result) : countsChart(result));
  for (Table& table : separationTables(result)) page.add(std::move(table));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/separate/1", make};

}  // namespace simgap::pages::separate
