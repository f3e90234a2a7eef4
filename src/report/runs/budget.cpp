#include "simgap/report/runs/budget.h"
#include "simgap/core/json_numbers.h"

#include <fmt/format.h>
#include <tinyxml2.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/text.h"
#include "simgap/diagnose/diagnosis.h"
#include "simgap/report/table.h"

namespace simgap {
namespace {

std::string boundsText(const BudgetLimit& limit) {
  const bool lower = std::isfinite(limit.lower), upper = std::isfinite(limit.upper);
  if (lower && upper) return fmt::format("between {:g} and {:g}", limit.lower, limit.upper);
  return lower ? fmt::format("at least {:g}", limit.lower) : fmt::format("at most {:g}", limit.upper);
}

void readBounds(const YamlNode& node, BudgetLimit& limit) {
  if (const auto lower = node.find("lower")) limit.lower = lower->number();
  if (const auto upper = node.find("upper")) limit.upper = upper->number();
  if (limit.lower > limit.upper) node.fail(fmt::format("found lower {:g} above upper {:g}", limit.lower, limit.upper));
}

std::vector<std::string> verdictNames() {
  using enum DiagnosisVerdict;
  std::vector<std::string> names;
  for (const DiagnosisVerdict verdict : {kCauseFound, kAmbiguous, kUnexplained, kNothingFound, kDataFault}) {
    names.emplace_back(toString(verdict));
  }
  return names;
}

BudgetLimit readLimit(const YamlNode& node) {
  BudgetLimit limit;
  if (const auto value = node.find("value")) {
    limit.subject = value->text();
    readBounds(node, limit);
  } else if (const auto parameter = node.find("parameter")) {
    limit.of = BudgetLimit::Of::kParameter;
    limit.subject = parameter->text();
    readBounds(node, limit);
    if (const auto sd = node.find("largest_sd_percent")) limit.largest_sd_percent = sd->number(kPositive);
  } else if (const auto verdicts = node.find("verdict")) {
    limit.of = BudgetLimit::Of::kVerdict;
    for (const YamlNode& verdict : verdicts->items()) limit.allowed.push_back(verdict.oneOf(verdictNames()));
    limit.text = fmt::format("verdict is one of {}", fmt::join(limit.allowed, ", "));
    return limit;
  } else if (const auto cause = node.find("cause")) {
    limit.of = BudgetLimit::Of::kCause;
    limit.subject = cause->text();
    limit.upper = 0.0;
    readBounds(node, limit);
    if (limit.upper < 0.0) node.fail(fmt::format("found upper {:g}, expected a gain >= 0 %", limit.upper));
    limit.text = limit.upper > 0.0 ? fmt::format("cause {} is worth at most {:g} %", limit.subject, limit.upper)
                                   : fmt::format("cause {} is not found", limit.subject);
    return limit;
  } else {
    node.fail("found none of value, parameter, verdict, cause, expected what is limited");
  }
  const bool bounded = std::isfinite(limit.lower) || std::isfinite(limit.upper);
  if (bounded) limit.text = fmt::format("{} is {}", limit.subject, boundsText(limit));
  if (std::isfinite(limit.largest_sd_percent)) {
    limit.text += fmt::format("{}{} is known to {:g} %", bounded ? ", " : "", limit.subject, limit.largest_sd_percent);
  }
  if (!limit.text.empty()) return limit;
  node.expectAllRead();  // a key with a slip of the pen first
  node.fail("found no limit, expected lower or upper");
}

/// What a limit met: in words, and whether it holds.
struct Finding {
  bool holds = false;
  std::string found;
};

Finding checkValue(const BudgetLimit& limit, const Json& result) {
  const Json* at = &result;
  std::string_view rest = limit.subject;
  while (!rest.empty()) {
    const std::string part(rest.substr(0, rest.find('.')));
    if (!at->is_object() || !at->contains(part)) return {false, fmt::format("no {} in result.json", limit.subject)};
    at = &at->at(part);
    rest = part.size() < rest.size() ? rest.substr(part.size() + 1) : std::string_view();
  }
  if (!at->is_number()) return {false, fmt::format("{}, which is no number", abridged(at->dump()))};
  const double value = at->get<double>();
  return {limit.lower <= value && value <= limit.upper, fmt::format("{:.5g}", value)};
}

Finding checkParameter(const BudgetLimit& limit, const Json& result) {
  std::string outside;
  std::size_t met = 0, outsiders = 0;
  for (const Json& p : result.value("parameters", Json::array())) {
    const std::string name = cellText(p.value("name", Json("")));
    if (!matchesGlob(limit.subject, name)) continue;
    ++met;
    const double value = numberOf(p.value("value", Json(nullptr))), sd = numberOf(p.value("sd", Json(nullptr)));
    const bool within = limit.lower <= value && value <= limit.upper;
    const bool known = p.value("identifiable", Json(true)) != false &&
                       (!std::isfinite(limit.largest_sd_percent) ||
                        100.0 * sd <= limit.largest_sd_percent * std::abs(value));  // false for an unknown one
    if (within && known) continue;
    if (++outsiders <= 3) {
      outside += fmt::format("{}{} is {:.5g}, sd {}", outside.empty() ? "" : "; ", name, value,
                             std::isfinite(sd) ? fmt::format("{:.2g}", sd) : "unknown");
    }
  }
  if (met == 0) return {false, "no such parameter"};
  if (outsiders == 0) return {true, fmt::format("{} of {}", met, met)};
  return {false, fmt::format("{}{}", outside, outsiders > 3 ? fmt::format("; and {} more", outsiders - 3) : "")};
}

Finding checkVerdict(const BudgetLimit& limit, const Json& result) {
  const std::string verdict = cellText(result.value("verdict", Json("")));
  if (verdict.empty()) return {false, "no verdict: the run is no diagnosis"};
  return {std::ranges::find(limit.allowed, verdict) != limit.allowed.end(), verdict};
}

/// Names by which a limit may mean a found cause: alone, with its target, and those of a group that it stands for.
std::vector<std::string> namesOfCause(const Json& cause) {
  std::vector<std::string> names = {cellText(cause.value("effect", Json("")))};
  if (const std::string target = cellText(cause.value("target", Json(""))); !target.empty()) {
    names.push_back(names[0] + ":" + target);
  }
  for (const Json& other : cause.value("ambiguous_with", Json::array())) {
    names.push_back(cellText(other));
    names.push_back(names.back().substr(0, names.back().find(':')));
  }
  return names;
}

/// Whether the run asked for a cause at all (hypotheses.csv): one that it did not ask for it cannot have excluded.
bool wasAskedFor(const BudgetLimit& limit, const ResultFiles& run) {
  if (!run.has("hypotheses.csv")) return false;
  const CsvTable asked = run.table("hypotheses.csv");
  const std::vector<std::string> effects = asked.text("effect"), targets = asked.text("target");
  for (std::size_t i = 0; i < effects.size(); ++i) {
    const std::string name = effects[i].substr(0, effects[i].find(" ("));  // without its form
    if (matchesGlob(limit.subject, name) || matchesGlob(limit.subject, name + ":" + targets[i])) return true;
  }
  return false;
}

Finding checkCause(const BudgetLimit& limit, const ResultFiles& run) {
  const Json& result = run.result();
  if (!result.contains("causes")) return {false, "no causes: the run is no diagnosis"};
  Finding finding{true, ""};
  for (const Json& cause : result.at("causes")) {
    const std::vector<std::string> names = namesOfCause(cause);
    const auto meant =
        std::ranges::find_if(names, [&](const std::string& name) { return matchesGlob(limit.subject, name); });
    if (meant == names.end()) continue;
    const double gain = numberOf(cause.value("gain_heldout_percent", Json(nullptr)));
    finding.found += fmt::format("{}{}, {:.3g} %", finding.found.empty() ? "" : "; ", *meant, gain);
    if (!(gain <= limit.upper)) finding.holds = false;
  }
  if (!finding.found.empty()) return finding;
  if (!wasAskedFor(limit, run)) return {false, "the run did not ask for it"};
  return {true, "none"};
}

}  // namespace

Budget readBudget(const YamlNode& root) {
  root.at("format").oneOf({"simgap/budget/1"});
  Budget budget;
  for (const YamlNode& node : root.at("limits").items()) budget.limits.push_back(readLimit(node));
  if (budget.limits.empty()) root.at("limits").fail("found no limit, expected one or more");
  root.expectAllRead();
  return budget;
}

Json checkBudget(const Budget& budget, const ResultFiles& run) {
  Json limits = Json::array();
  std::size_t held = 0, of = budget.limits.size();
  // The numbers of a run that failed are of a result that it does not deliver.
  if (const std::string status = cellText(run.run().value("status", Json(""))); status != "done") {
    limits.push_back({{"limit", "the run is done"}, {"found", status}, {"pass", false}});
    ++of;
  }
  for (const BudgetLimit& limit : budget.limits) {
    const Json& result = run.result();
    const Finding finding = limit.of == BudgetLimit::Of::kValue       ? checkValue(limit, result)
                            : limit.of == BudgetLimit::Of::kParameter ? checkParameter(limit, result)
                            : limit.of == BudgetLimit::Of::kVerdict   ? checkVerdict(limit, result)
                                                                      : checkCause(limit, run);
    held += finding.holds;
    limits.push_back({{"limit", limit.text}, {"found", finding.found}, {"pass", finding.holds}});
  }
  return {
      {"format", "simgap/guard/1"}, {"run", run.directory().string()}, {"held", held}, {"of", of}, {"limits", limits}};
}

bool holds(const Json& guard) { return guard.at("held") == guard.at("of"); }

std::string guardText(const Json& guard) {
  std::string text = fmt::format("{} of {} limits hold.\n\n", cellText(guard.at("held")), cellText(guard.at("of")));
  std::vector<std::vector<std::string>> rows{{"limit", "found", ""}};
  for (const Json& limit : guard.at("limits")) {
    rows.push_back({cellText(limit.at("limit")), cellText(limit.at("found")), limit.at("pass") ? "ok" : "BROKEN"});
  }
  return text + alignedTable(rows);
}

std::string guardMarkdown(const Json& guard) {
  const auto cell = [](const Json& text) {
    std::string escaped;
    for (const char c : printable(cellText(text))) escaped += c == '|' ? "\\|" : std::string(1, c);
    return escaped;
  };
  std::string text = fmt::format("### {} of {} limits hold\n\n| limit | found | |\n|---|---|---|\n",
                                 cellText(guard.at("held")), cellText(guard.at("of")));
  for (const Json& limit : guard.at("limits")) {
    text += fmt::format("| {} | {} | {} |\n", cell(limit.at("limit")), cell(limit.at("found")),
                        limit.at("pass") ? "ok" : "**broken**");
  }
  return text;
}

std::string guardJunit(const Json& guard) {
  tinyxml2::XMLPrinter xml;
  xml.PushHeader(/*writeBOM=*/false, /*writeDeclaration=*/true);
  xml.OpenElement("testsuite");
  xml.PushAttribute("name", "simgap guard");
  const std::int64_t of = wholeNumber(guard.at("of"));
  xml.PushAttribute("tests", of);
  xml.PushAttribute("failures", of - wholeNumber(guard.at("held")));
  for (const Json& limit : guard.at("limits")) {
    xml.OpenElement("testcase");
    xml.PushAttribute("classname", "simgap.guard");
    xml.PushAttribute("name", printable(cellText(limit.at("limit"))).c_str());
    if (!limit.at("pass")) {
      xml.OpenElement("failure");
      xml.PushAttribute("message", ("found " + printable(cellText(limit.at("found")))).c_str());
      xml.CloseElement();
    }
    xml.CloseElement();
  }
  xml.CloseElement();
  return xml.CStr();
}

}  // namespace simgap
