#include "simgap/report/decode/decode_report.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::decode_train {
namespace {

Chart lossChart(const Json& result) {
  Series losses{"held out", {}, {}};
  for (const Json& penalty : result.at("penalties")) {
    losses.x.push_back(numberOf(penalty.at("part")));
    losses.y.push_back(numberOf(penalty.at("loss")));
  }
  Chart chart = lineChart("What the penalty costs and gains", {"part of the penalty that leaves no weight", true},
                          {"loss of a window"}, {losses});
  chart.note = "By folds of whole trials. The least loss is chosen; a coin would lose 0.693.";
  return chart;
}

Chart patternChart(const ResultFiles& files) {
  const CsvTable table = files.table("patterns.csv");
  std::vector<Series> bars;
  for (const std::string& column : table.columns()) {
    if (column != "channel") bars.push_back({column, {}, numbersOf(table, column)});
  }
  Chart chart = barChart("The strongest directions of the weights", table.text("channel"), {"part of a channel"}, bars);
  chart.note = "More power along one named up speaks for up, along one named down for down.";
  chart.wide = true;
  return chart;
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"A decoder of two states", decodeTrainAnswer(result), {}};
  const bool better = result.at("better_than_chance").get<bool>();
  page.verdict = {better ? PageVerdict::Level::kGood : PageVerdict::Level::kBad,
                  better ? "better than chance" : "no better than chance",
                  better ? "" : "Record more trials, or ask for states that differ more.",
                  better ? "simgap decode run " + files.path("decoder.yaml") + " RECORDING.csv" : ""};
  page.add(lossChart(result));
  if (files.has("patterns.csv")) page.add(patternChart(files));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/decode-train/1", make};

}  // namespace simgap::pages::decode_train
