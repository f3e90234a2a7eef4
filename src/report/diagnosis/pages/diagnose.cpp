#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "report/diagnosis/cause_table.h"
#include "report/diagnosis/evidence_charts.h"
#include "report/diagnosis/motion_says.h"
#include "report/diagnosis/robot_says.h"
#include "report/motions/motion_tables.h"
#include "report/poses/arm_scene.h"
#include "simgap/core/units.h"
#include "simgap/report/html/result_page.h"

namespace simgap::pages::diagnose {
namespace {

std::string text(const Json& object, const char* key) { return object.value(key, std::string()); }

std::string joined(const Json& words) {
  std::string all;
  for (const Json& word : words) all += (all.empty() ? "" : ", ") + word.get<std::string>();
  return all;
}

/// Squared errors are in "A2"; their roots in "A".
std::string rootUnit(const Json& result) {
  const std::string unit = text(result, "error_unit");
  return unitTitle(unit.ends_with('2') ? unit.substr(0, unit.size() - 1) : unit);
}

std::vector<std::string> notes(const Json& result) {
  std::vector<std::string> notes;
  for (const Json& fault : result.value("faults", Json::array())) notes.push_back(text(fault, "sentence"));
  for (const Json& cause : result.at("causes")) {
    const std::string rivals = joined(cause.at("ambiguous_with"));
    if (!rivals.empty()) notes.push_back(causeName(cause) + " cannot be told apart here from " + rivals + ".");
  }
  for (const Json& left : result.value("left_over", Json::object()).value("channels", Json::array())) {
    notes.push_back(fmt::format("{} % of the error depends on {} in a way that no known cause explains.",
                                numberText(left.at("share_percent"), "{:.1f}"), text(left, "channel")));
  }
  for (const Json& candidate : result.value("candidates", Json::array())) {
    notes.push_back(
        fmt::format("{} is a candidate, not a finding: {}.", causeName(candidate), text(candidate, "reason")));
  }
  for (const Json& warning : result.value("warnings", Json::array())) notes.push_back(warning);
  return notes;
}

/// How large the gap is, and how small any model could make it.
Chart gap(const Json& result) {
  const auto rms = [](const Json& mse) { return std::sqrt(numberOf(mse)); };
  const std::vector<double> errors = {rms(result.at("baseline").at("noise_floor")),
                                      rms(result.at("baseline").at("mse_heldout")),
                                      rms(result.at("extended").at("mse_heldout"))};
  Chart chart = barChart("The gap on data never used", {"noise floor", "the model as it is", "with the causes"},
                         {fmt::format("RMS error [{}]", rootUnit(result))}, {{"RMS error", {}, errors}});
  chart.note = "No model can go below the noise floor.";
  return chart;
}

void addCauses(const Json& result, Page& page) {
  if (result.at("causes").empty()) return;
  std::vector<IntervalRow> rows;
  Table table = causeTable(result);  // and, where a page has the room, what carried the effect before
  table.header.insert(table.header.end(), {"had been carried by", "what it is"});
  for (std::size_t c = 0; c < table.rows.size(); ++c) {
    const Json& cause = result.at("causes").at(c);
    const Json& interval = cause.at("gain_ci95");
    rows.push_back({causeName(cause), numberOf(cause.at("gain_heldout_percent")), numberOf(interval.at(0)),
                    numberOf(interval.at(1))});
    std::string carriers;
    for (const Json& a : cause.at("absorbed_by")) {
      carriers += fmt::format("{}{} ({} sd)", carriers.empty() ? "" : ", ", text(a, "parameter"),
                              numberText(a.at("shift_sd"), "{:+.1f}"));
    }
    table.rows[c].insert(table.rows[c].end(), {carriers, text(cause, "sentence")});
  }
  Chart gains = intervalChart("What each cause saves on data never used", {"of the mean squared error [%]"}, rows);
  gains.note = "With the interval in which it lies, with 95 %, on other data as large as these.";
  page.add(std::move(gains));
  page.add(std::move(table));
}

void addPredictions(const ResultFiles& files, Page& page) {
  if (!files.has("predictions.csv")) return;
  page.addSection("Over time");
  const CsvTable table = files.table("predictions.csv");
  const std::vector<double> time = numbersOf(table, "time_s");
  Chart chart = lineChart("Measured and predicted", {"time [s]"}, {fmt::format("[{}]", rootUnit(files.result()))},
                          {{"measured", time, numbersOf(table, "measured"), Series::Style::kLine, 6, /*faint=*/true},
                           {"before", time, numbersOf(table, "before"), Series::Style::kLine, 1},
                           {"with the causes", time, numbersOf(table, "after"), Series::Style::kLine, 0}});
  chart.wide = true;
  makeZoomable(chart);
  page.add(std::move(chart));
  const auto left = [&](const char* column) {
    std::vector<double> rest = numbersOf(table, "measured");
    const std::vector<double> predicted = numbersOf(table, column);
    for (std::size_t i = 0; i < rest.size(); ++i) rest[i] -= predicted[i];
    return rest;
  };
  Chart residual =
      lineChart("What is left: measured - predicted", {"time [s]"}, {fmt::format("[{}]", rootUnit(files.result()))},
                {{"with the causes", time, left("after"), Series::Style::kLine, 0},
                 {"before", time, left("before"), Series::Style::kLine, 1, /*faint=*/true}});
  residual.wide = true;
  makeZoomable(residual);
  page.add(std::move(residual));
}

/// The signature: of all channels the one against which the causes took away most of the mean residual.
void addSignature(const ResultFiles& files, const EvidenceTable& evidence, Page& page) {
  if (files.result().at("causes").empty() || evidence.channels.empty()) return;
  Chart chart = evidenceChart(evidence.table, evidence.channels.front(), rootUnit(files.result()));
  chart.note = "The signature: what the model missed before, and what is left of it with the causes.";
  chart.wide = true;
  page.add(std::move(chart));
}

/// The others, ranked: what is left over shows as a shape.
void addEvidence(const ResultFiles& files, const EvidenceTable& evidence, Page& page) {
  if (evidence.channels.empty()) return;
  page.addSection("Evidence: the mean residual against what was logged", /*folded=*/true);
  for (const std::string& against : evidence.channels) {
    page.add(evidenceChart(evidence.table, against, rootUnit(files.result())));
  }
}

/// The rivals of the first step, best first, and the record of all steps.
void addHypotheses(const ResultFiles& files, Page& page) {
  constexpr std::size_t kMost = 20;
  if (!files.has("hypotheses.csv")) return;
  const CsvTable table = files.table("hypotheses.csv");
  if (table.rows() == 0) return;
  const auto step = table.text("step"), effect = table.text("effect"), target = table.text("target");
  const auto outcome = table.text("outcome");
  const auto gain = numbersOf(table, "gain_percent"), p = numbersOf(table, "p_adjusted");
  const auto lower = numbersOf(table, "gain_lower95_percent"), upper = numbersOf(table, "gain_upper95_percent");
  const bool has_odds = std::ranges::find(table.columns(), "log_odds") != table.columns().end();
  const auto odds = has_odds ? numbersOf(table, "log_odds") : std::vector<double>(step.size(), std::nan(""));
  const bool by_odds = std::ranges::any_of(odds, [](double value) { return std::isfinite(value); });
  std::vector<IntervalRow> rivals;
  Table record{"All steps", {"hypothesis", "step", "gain [%]", "p (adjusted)", "outcome"}, {}, true};
  for (std::size_t i = 0; i < step.size(); ++i) {
    const std::string name = effect[i] + (target[i].empty() ? "" : " of " + target[i]);
    record.rows.push_back(
        {name, step[i], numberText(numberOrNull(gain[i]), "{:.2f}"), probabilityText(numberOrNull(p[i])), outcome[i]});
    const double value = by_odds ? odds[i] : gain[i];
    if (step[i] != step.front() || !std::isfinite(value)) continue;
    const bool accepted = outcome[i].starts_with("accepted"), ambiguous = outcome[i] == "ambiguous";
    rivals.push_back({name, value, by_odds ? value : lower[i], by_odds ? value : upper[i],
                      accepted    ? "accepted"
                      : ambiguous ? "ambiguous"
                                  : "rejected",
                      accepted    ? 0
                      : ambiguous ? 1
                                  : 6});
  }
  std::ranges::stable_sort(rivals, std::greater(), &IntervalRow::value);
  const std::size_t count = rivals.size();
  rivals.resize(std::min(count, kMost));
  page.addSection("What was tested");
  if (!rivals.empty()) {
    Chart chart =
        intervalChart("Rivals of the first step, best first",
                      {by_odds ? "log odds against the model without it" : "gain on blocks not fitted [%]"}, rivals);
    if (count > kMost) chart.note = fmt::format("The {} best of {}.", kMost, count);
    chart.wide = true;
    page.add(std::move(chart));
  }
  page.add(std::move(record));
}

/// The arm in its poses with and without the causes, those first that gain most.
void addArm(const ResultFiles& files, Page& page) {
  if (!files.has("poses.csv")) return;
  const CsvTable table = files.table("poses.csv");
  const std::vector<std::string> names = table.text("pose");
  const std::vector<double> before = numbersOf(table, "before_deg"), after = numbersOf(table, "after_deg");
  std::vector<std::size_t> order(names.size());
  for (std::size_t i = 0; i < order.size(); ++i) order[i] = i;
  std::ranges::stable_sort(order, std::greater(), [&](std::size_t i) { return before[i] - after[i]; });
  std::vector<ScenePose> poses;
  Series bars_before{"before", {}, {}}, bars_after{"with the causes", {}, {}};
  std::vector<std::string> labels;
  for (const std::size_t i : order) {
    poses.push_back({"all",
                     names[i],
                     {{"given", fmt::format("the model as given; RMS {:.2f}° after a fit", before[i])},
                      {"with the causes", fmt::format("RMS {:.2f}°", after[i])}}});
    labels.push_back(names[i]);
    bars_before.y.push_back(before[i]);
    bars_after.y.push_back(after[i]);
  }
  bars_before.faint = true;
  bars_before.colour = bars_after.colour = 0;
  auto scene = armScene(files, poses);
  if (!scene) return;
  scene->scene["slider"] = "pose, the largest gain first";
  page.addSection("The arm in its poses");
  page.add(std::move(*scene));
  Chart chart = barChart("Error of each pose, the largest gain first", labels, {"RMS joint error [deg]"},
                         {bars_before, bars_after});
  chart.wide = true;
  chart.spec["poses"] = "all";
  page.add(std::move(chart));
}

/// The held-out motion that shows most of the causes, played without and with them beside what was measured.
void addPlayedMotion(const ResultFiles& files, Page& page) {
  if (files.has("poses.csv") || !files.has("arm_bodies.csv")) return;
  const CsvTable table = files.table("arm_bodies.csv");
  const std::vector<std::string> sets = distinctOf(table, "set"), frames = distinctOf(table, "pose");
  std::vector<std::pair<std::string, std::string>> states;
  for (const std::string& state : distinctOf(table, "state")) {
    if (state != "measured") states.emplace_back(state, "");
  }
  std::vector<ScenePose> poses;
  for (const std::string& frame : frames) poses.push_back({sets.front(), frame, states});
  const auto seconds = [](const std::string& frame) {
    return parseNumber(frame.substr(0, frame.find(' '))).value_or(0.0);
  };
  auto scene = armScene(files, poses, SceneMotion{seconds(frames.back()) - seconds(frames.front()), true});
  if (!scene) return;
  page.addSection("Motion " + sets.front() + ", which no fit has seen");
  page.add(std::move(*scene));
}

/// How often a cause hidden in this design would be named rightly.
void addSelfTest(const Json& result, Page& page) {
  if (!result.contains("self_test")) return;
  const Json& test = result.at("self_test");
  Map map;
  map.x_names = test.at("answers").get<std::vector<std::string>>();
  const Json& hidden = test.at("hidden");
  const Json& counts = test.at("count");
  for (std::size_t a = 0; a < map.x_names.size(); ++a) map.x.push_back(static_cast<double>(a));
  for (std::size_t h = hidden.size(); h-- > 0;) {  // the first row of the matrix stands at the top
    map.y.push_back(static_cast<double>(map.y.size()));
    map.y_names.push_back(hidden.at(h));
    for (const Json& count : counts.at(h)) map.value.push_back(numberOf(count));
  }
  map.written = true;
  map.unit = "trials";
  page.addSection("Could these data have answered?");
  const auto percent = [&](const char* key) { return fmt::format("{:.0f} %", 100.0 * numberOf(test.at(key))); };
  page.add(PageText{"Causes hidden in this very design: false alarms in " + percent("false_alarm_rate") +
                    " of the trials without any, power " + percent("power") + "."});
  Chart chart = mapChart("Self-test: what was hidden, and what was named", {"named"}, {"hidden"}, map);
  chart.wide = true;
  page.add(std::move(chart));
}

void addLimits(const Json& result, Page& page) {
  const Json detectable = result.value("detectable", Json::array());
  if (!detectable.empty()) {
    Table table{"The smallest effect these data could have shown",
                {"effect", "parameter", "magnitude (95 %)", "unit"},
                {},
                detectable.size() > 12};
    for (const Json& d : detectable) {
      table.rows.push_back(
          {causeName(d), text(d, "parameter"), numberText(d.at("magnitude95"), "{:.3g}"), unitTitle(text(d, "unit"))});
    }
    page.add(std::move(table));
  }
  const Json untested = result.value("not_testable", Json::array());
  if (!untested.empty()) {
    Table table{"Not testable with these data", {"effect", "because"}, {}};
    for (const Json& n : untested) table.rows.push_back({text(n, "effect"), text(n, "reason")});
    page.add(std::move(table));
  }
}

Table figures(const Json& result) {
  const std::string unit = unitTitle(text(result, "error_unit"));
  const Json &baseline = result.at("baseline"), &extended = result.at("extended");
  Table table{fmt::format("Mean squared errors [{}]", unit), {"", "fitted", "never used"}, {}};
  table.rows = {
      {"the model as it is", numberText(baseline.at("mse"), "{:.4g}"),
       numberText(baseline.at("mse_heldout"), "{:.4g}")},
      {"with the causes", numberText(extended.at("mse"), "{:.4g}"), numberText(extended.at("mse_heldout"), "{:.4g}")},
      {"noise floor", "", numberText(baseline.at("noise_floor"), "{:.4g}")}};
  return table;
}

/// What the answer is worth, and what goes on from it.
PageVerdict verdictOf(const ResultFiles& files) {
  const Json& result = files.result();
  const std::string verdict = text(result, "verdict");
  const bool arm = files.has("poses.csv");
  PageVerdict shown{PageVerdict::Level::kGood, verdict, "", ""};
  if (verdict == "data-fault") {
    shown.level = PageVerdict::Level::kBad;
    shown.cause = "The data themselves are wrong: nothing was fitted.";
  } else if (verdict == "ambiguous") {
    shown.level = PageVerdict::Level::kDoubtful;
    shown.cause = "These data cannot tell some causes apart: record what is asked for below.";
  } else if (verdict == "unexplained") {
    shown.level = PageVerdict::Level::kDoubtful;
    const bool seen = !result.value("left_over", Json::object()).value("channels", Json::array()).empty();
    shown.cause = seen ? "What is left depends on what was logged, and no known cause explains it."
                       : "What is left is far above the noise, and neither a known cause nor a channel explains it.";
  } else if (verdict == "nothing-found") {
    shown.cause = "No known cause makes the model better on data never used.";
  } else {
    shown.cause = "The causes hold on data that found none of them; the extended model is model.yaml.";
    const std::string model = files.path("model.yaml");
    shown.command = result.contains("motions") ? fmt::format("simgap validate {} --motions OTHER_MOTIONS.yaml", model)
                    : arm                      ? fmt::format("simgap validate {} --poses OTHER_POSES.csv", model)
                                               : fmt::format("simgap predict {} OTHER_LOG.csv", model);
  }
  return shown;
}

/// Which motion spoke for which cause, and the errors over time.
void addMotions(const ResultFiles& files, Page& page) {
  if (!files.result().contains("motions")) return;
  page.addSection("Motions");
  Table says = motionSays(files.result());
  page.add(std::move(says));
  if (files.has("residuals.csv")) addResidualCharts(files, page);
}

/// What is left of each joint of a robot.
void addJoints(const Json& result, Page& page) {
  if (!result.contains("joints") || result.at("joints").empty()) return;
  page.add(robotSays(result));
}

Page make(const ResultFiles& files) {
  const Json& result = files.result();
  const std::string sentence = text(result, "sentence");
  Page page{"simgap diagnose", sentence.empty() ? "Verdict: " + text(result, "verdict") + "." : sentence,
            notes(result)};
  page.verdict = verdictOf(files);
  const EvidenceTable evidence = evidenceOf(files);
  addSignature(files, evidence, page);
  if (result.at("baseline").at("mse_heldout").is_number()) page.add(gap(result));
  addCauses(result, page);
  addJoints(result, page);
  page.add(
      PageText{fmt::format("Verdict: {}. The named causes explain {} % of the error; some {} % is "
                           "explainable.",
                           text(result, "verdict"), numberText(result.at("explained_percent"), "{:.0f}"),
                           numberText(result.at("explainable_percent"), "{:.0f}"))});
  if (const std::string next = text(result, "next_experiment"); !next.empty()) {
    page.addSection("What to record next");
    page.add(PageText{next});
  }
  addArm(files, page);
  addPlayedMotion(files, page);
  addEvidence(files, evidence, page);
  addPredictions(files, page);
  addMotions(files, page);
  addSelfTest(result, page);
  addHypotheses(files, page);
  addLimits(result, page);
  page.add(figures(result));
  return page;
}

}  // namespace

extern const ResultPage entry;
const ResultPage entry{"simgap/diagnose/1", make};

}  // namespace simgap::pages::diagnose
