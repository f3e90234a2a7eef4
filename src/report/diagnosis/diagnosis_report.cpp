#include "simgap/report/diagnosis/diagnosis_report.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "cause_table.h"
#include "simgap/core/csv.h"

namespace simgap {
namespace {

Json pair(const Interval& interval, double scale = 1.0) {
  return {numberOrNull(scale * interval.lower95), numberOrNull(scale * interval.upper95)};
}

std::string percent(double fraction) { return fmt::format("{:.1f} %", 100.0 * fraction); }

Json selfTestJson(const SelfTest& test) {
  return {{"hidden", test.hidden},
          {"answers", test.answers},
          {"count", test.count},
          {"false_alarm_rate", numberOrNull(test.false_alarm_rate)},
          {"power", numberOrNull(test.power)}};
}

Json causesJson(const Diagnosis& d) {
  Json causes = Json::array();
  for (const Cause& c : d.causes) {
    Json parameters = Json::array(), absorbed = Json::array();
    for (const Estimate& p : c.parameters) {
      parameters.push_back({{"name", p.name},
                            {"unit", p.unit},
                            {"value", numberOrNull(p.value)},
                            {"ci95", pair({p.value, p.lower95, p.upper95})}});
    }
    for (const Absorption& a : c.absorbed_by) {
      absorbed.push_back({{"parameter", a.parameter}, {"shift_sd", numberOrNull(a.shift_sd)}});
    }
    Json cause = {{"effect", c.effect},
                  {"sentence", c.sentence},
                  {"parameters", parameters},
                  {"gain_heldout_percent", numberOrNull(100.0 * c.gain_heldout.value)},
                  {"gain_ci95", pair(c.gain_heldout, 100.0)},
                  {"p_adjusted", numberOrNull(c.p_adjusted)},
                  {"ambiguous_with", c.ambiguous_with},
                  {"absorbed_by", absorbed}};
    if (!c.form.empty()) cause["form"] = c.form;
    if (!c.target.empty()) cause["target"] = c.target;
    if (!c.channel.empty()) cause["channel"] = c.channel;
    causes.push_back(cause);
  }
  return causes;
}

/// The causes as a table and in words, and what they save.
std::string causesText(const Diagnosis& d, const Json& result) {
  std::string text = "\n" + alignedTable(causeTable(result)) + "\n";
  for (const Json& cause : result.at("causes")) {
    text += fmt::format("{}: {}\n", causeName(cause), cause.at("sentence").get<std::string>());
    const auto rivals = cause.at("ambiguous_with").get<std::vector<std::string>>();
    if (!rivals.empty()) text += fmt::format("  cannot be told apart here from: {}\n", fmt::join(rivals, ", "));
  }
  text += fmt::format("\ngain      RMS {:.4g} → {:.4g} on data never used\n", std::sqrt(d.baseline.mse_heldout),
                      std::sqrt(d.extended.mse_heldout));
  std::vector<std::string> absorbed;
  for (const Absorption& a : d.causes.back().absorbed_by) {
    absorbed.push_back(fmt::format("{} ({:+.1f} sd)", a.parameter, a.shift_sd));
  }
  if (!absorbed.empty()) text += fmt::format("absorbed  had been carried by {}\n", fmt::join(absorbed, ", "));
  return text;
}

}  // namespace

Json toJson(const Diagnosis& d) {
  Json detectable = Json::array(), not_testable = Json::array(), faults = Json::array(), unexplained = Json::array(),
       candidates = Json::array();
  for (const Detectable& x : d.detectable) {
    detectable.push_back({{"effect", x.effect},
                          {"target", x.target},
                          {"parameter", x.parameter},
                          {"unit", x.unit},
                          {"magnitude95", numberOrNull(x.magnitude95)}});
  }
  for (const NotTestable& x : d.not_testable) not_testable.push_back({{"effect", x.effect}, {"reason", x.reason}});
  for (const DataFault& f : d.faults) {
    faults.push_back({{"channel", f.channel},
                      {"sentence", f.sentence},
                      {"first_row", f.first_row},
                      {"last_row", f.last_row},
                      {"rows", f.rows},
                      {"corrected", f.corrected}});
  }
  for (const Leftover& l : d.unexplained) {
    unexplained.push_back(
        {{"channel", l.channel}, {"share_percent", numberOrNull(100.0 * l.share)}, {"shape", l.shape}});
  }
  for (const Candidate& c : d.candidates) {
    candidates.push_back({{"effect", c.effect},
                          {"target", c.target},
                          {"reason", c.reason},
                          {"gain_heldout_percent", numberOrNull(100.0 * c.gain_heldout.value)}});
  }
  Json json = {
      {"format", "simgap/diagnose/1"},
      {"verdict", toString(d.verdict)},
      {"sentence", d.sentence},
      {"causes", causesJson(d)},
      {"baseline",
       {{"mse", numberOrNull(d.baseline.mse)},
        {"mse_heldout", numberOrNull(d.baseline.mse_heldout)},
        {"noise_floor", numberOrNull(d.noise_floor)}}},
      {"extended", {{"mse", numberOrNull(d.extended.mse)}, {"mse_heldout", numberOrNull(d.extended.mse_heldout)}}},
      {"error_unit", d.error_unit},
      {"n", d.samples},
      {"n_effective", numberOrNull(d.effective_samples)},
      {"explainable_percent", numberOrNull(d.explainable_percent)},
      {"explained_percent", numberOrNull(d.explained_percent)},
      {"left_over", {{"share_percent", numberOrNull(d.left_over_percent)}, {"channels", unexplained}}},
      {"candidates", candidates},
      {"detectable", detectable},
      {"not_testable", not_testable},
      {"faults", faults},
      {"next_experiment", d.next_experiment},
      {"warnings", d.warnings}};
  if (d.self_test) json["self_test"] = selfTestJson(*d.self_test);
  return json;
}

std::string hypothesesCsv(const Diagnosis& d) {
  CsvWriter csv({"step", "effect", "target", "gain_percent", "gain_lower95_percent", "gain_upper95_percent",
                 "p_adjusted", "log_odds", "outcome"});
  const auto number = [](double value) { return std::isfinite(value) ? fmt::format("{}", value) : std::string(); };
  for (const HypothesisRecord& h : d.hypotheses) {
    csv.add(static_cast<double>(h.step)).add(h.effect).add(h.target).add(number(100.0 * h.gain_inner.value));
    csv.add(number(100.0 * h.gain_inner.lower95)).add(number(100.0 * h.gain_inner.upper95)).add(h.p_adjusted);
    csv.add(h.log_odds ? number(*h.log_odds) : "").add(h.outcome).endRow();
  }
  return csv.text();
}

std::string evidenceCsv(const Diagnosis& d) {
  CsvWriter csv({"against", "center", "before", "before_ci95", "after", "after_ci95", "rows", "unit"});
  for (const EvidenceBin& b : d.evidence) {
    csv.add(b.against).add(b.center).add(b.before).add(b.before_ci95).add(b.after).add(b.after_ci95);
    csv.add(static_cast<double>(b.rows)).add(b.unit).endRow();
  }
  return csv.text();
}

std::string terminalTable(const Diagnosis& d) {
  const Json result = toJson(d);
  std::string text = d.sentence + "\n\n";
  std::string unit = d.error_unit;  // of squares: "A2"
  if (unit.ends_with('2')) unit.pop_back();
  unit = unitTitle(unit);
  if (d.verdict != DiagnosisVerdict::kDataFault) {
    text +=
        fmt::format("gap       RMS {:.4g} {} on data never used, noise floor {}\n", std::sqrt(d.baseline.mse_heldout),
                    unit, d.noise_floor > 0.0 ? fmt::format("{:.4g} {}", std::sqrt(d.noise_floor), unit) : "unknown");
  }
  for (const DataFault& f : d.faults) text += fmt::format("fault     {}\n", f.sentence);
  if (!d.causes.empty()) text += causesText(d, result);
  for (const Candidate& c : d.candidates)
    text += fmt::format("candidate {}, not named: {}\n", c.target.empty() ? c.effect : c.effect + " of " + c.target,
                        c.reason);
  if (!d.causes.empty() || d.verdict == DiagnosisVerdict::kUnexplained) {  // else there is nothing to explain
    text += fmt::format("explained {:.0f} % of the error; some {:.0f} % is explainable\n", d.explained_percent,
                        d.explainable_percent);
  }
  for (const Leftover& l : d.unexplained) {
    constexpr double kNothing = 0.005;  // of the error: the share of a channel that was asked, too
    if (l.share < kNothing) continue;
    text += fmt::format("left over {} of the error, by {}{}\n", percent(l.share), l.channel,
                        l.shape.empty() ? "" : ": " + l.shape);
  }
  if (!d.not_testable.empty()) {
    std::vector<std::string> names;
    for (const NotTestable& x : d.not_testable) names.push_back(x.effect);
    text += fmt::format("untested  {} (reasons in result.json)\n", fmt::join(names, ", "));
  }
  if (d.self_test) {
    text += "\n" + alignedTable(confusionTable(result));
    text += fmt::format("self-test: false alarms {}, power {}\n", percent(d.self_test->false_alarm_rate),
                        percent(d.self_test->power));
  }
  if (!d.next_experiment.empty()) text += fmt::format("\nnext      {}\n", d.next_experiment);
  return text + "\n";
}

}  // namespace simgap
