#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/motions/motion_tables.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::calibrate_motions {
namespace {

std::string answer(const Json& result) {
  if (result.at("failure").is_string()) return "Failed: " + result.at("failure").get<std::string>() + ".";
  const bool held_out = result.at("motion_rms").contains("validation");
  const Json& rms = result.at("motion_rms").at(held_out ? "validation" : "calibration");
  std::string text = held_out ? "On motions the fit never saw the gap went" : "On the motions it was fitted to it went";
  const char* separator = "";
  for (const auto& [channel, initial] : rms.at("initial").items()) {
    text += fmt::format("{} from {} to {} ({})", separator, numberText(initial, "{:.3f}"),
                        numberText(rms.at("final").at(channel), "{:.3f}"), channel);
    separator = ",";
  }
  return text + ".";
}

/// Whether a channel of held-out motions is missed by clearly more than was expected of it.
bool surprises(const Json& result) {
  constexpr double kClearly = 1.25;  // times the upper limit: of many channels one is beyond it by chance
  const auto predicted = result.find("predicted_motion_rms");
  if (predicted == result.end() || !predicted->contains("validation")) return false;
  const Json& final = result.at("motion_rms").at("validation").at("final");
  for (const auto& [channel, upper] : predicted->at("validation").at("upper").items()) {
    if (numberOf(final.at(channel)) > kClearly * numberOf(upper)) return true;
  }
  return false;
}

PageVerdict verdictOf(const ResultFiles& files) {
  using enum PageVerdict::Level;
  const Json& result = files.result();
  const std::string model = files.path("model.yaml");
  const std::string validate = fmt::format("simgap validate {} --motions OTHER_MOTIONS.yaml", model);
  if (result.at("failure").is_string()) return {kBad, "worse than the start", result.at("failure"), validate};
  if (result.at("optimizer") == "lm" && !result.at("converged").get<bool>()) {
    return {kDoubtful, "not converged", "The search was cut off: intervals may be far too narrow.",
            "simgap calibrate MODEL.yaml --motions MOTIONS.yaml --config MORE_ROUNDS.yaml"};
  }
  if (result.at("misfit").get<double>() > 1.5) {
    return {kDoubtful, "something is not in the model", "Residuals are larger than noise and model leave.", validate};
  }
  if (!result.at("motion_rms").contains("validation")) {
    return {kDoubtful, "not judged", "Only motions it was not fitted to can show what it is worth.", validate};
  }
  if (surprises(result)) {
    return {kDoubtful, "missed by more than expected",
            "Motions it never saw are missed by more than the model's own uncertainty.", validate};
  }
  return {kGood, "good", "It holds on motions the fit never saw.", validate};
}

Chart movedChart(const Json& result) {
  constexpr std::size_t kMost = 30;
  std::vector<IntervalRow> rows;
  for (const Json& p : result.at("parameters")) {
    const double prior = numberOf(p.at("prior_sd")), shift = numberOf(p.at("shift_sd"));
    if (!std::isfinite(prior) || !std::isfinite(shift)) continue;
    const double sd = numberOf(p.at("sd")) / prior;
    IntervalRow row{p.at("name"), shift, shift - sd, shift + sd, p.at("identifiable")};
    row.colour = row.group == "not identifiable" ? 6 : row.group == "weak" ? 1 : 0;
    row.marked = p.at("at_bound");
    rows.push_back(std::move(row));
  }
  std::ranges::stable_sort(rows, std::greater(), [](const IntervalRow& row) { return std::abs(row.value); });
  rows.resize(std::min(rows.size(), kMost));
  Chart chart = intervalChart("Parameters moved most", {"change / prior standard deviation"}, rows);
  chart.wide = true;
  return chart;
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  Page page{"simgap calibrate", answer(result), {}};
  page.verdict = verdictOf(files);
  page.add(calibrationRms(result));
  page.addSection("Parameters");
  page.add(movedChart(result));
  if (!result.at("combinations").empty()) {
    Table known{"Known only together", {"parameters"}, {}, true};
    for (const Json& words : result.at("combinations")) known.rows.push_back({words});
    page.add(std::move(known));
  }
  Table all = recordTable("All parameters", result.at("parameters"),
                          {"name", "unit", "initial", "value", "sd", "prior_sd", "shift_sd", "identifiable"});
  all.folded = true;
  page.add(std::move(all));
  page.addSection("Errors over time");
  addResidualCharts(files, page);
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/calibrate-motions/1", make};

}  // namespace simgap::pages::calibrate_motions
