#include "cause_table.h"

#include <fmt/format.h>

namespace simgap {
namespace {

/// "radius = 0.05 ± 0.01 m"; without the interval what was chosen, not fitted.
std::string parameterText(const Json& parameter) {
  const std::string name = parameter.at("name"), unit = parameter.at("unit");
  const Json& interval = parameter.at("ci95");
  const double half = 0.5 * (numberOf(interval.at(1)) - numberOf(interval.at(0)));
  return fmt::format("{} = {:.4g}{}{}", name, numberOf(parameter.at("value")),
                     half > 0.0 ? fmt::format(" ± {:.2g}", half) : "", unit == "1" ? "" : " " + unitTitle(unit));
}

}  // namespace

std::string causeName(const Json& cause) {
  const std::string target = cause.value("target", std::string()), form = cause.value("form", std::string());
  return cause.at("effect").get<std::string>() + (target.empty() ? "" : " of " + target) +
         (form.empty() ? "" : " (" + form + ")");
}

Table causeTable(const Json& result) {
  Table table{"Causes, in the order they were found",
              {"cause", "held-out gain (95 % on new data)", "p (adjusted)", "parameters"},
              {}};
  for (const Json& cause : result.at("causes")) {
    const Json& interval = cause.at("gain_ci95");
    std::string parameters;
    for (const Json& p : cause.at("parameters")) {
      if (p.at("value").is_number()) parameters += (parameters.empty() ? "" : ", ") + parameterText(p);
    }
    table.rows.push_back({causeName(cause),
                          fmt::format("{:.1f} % ({:.1f} … {:.1f})", numberOf(cause.at("gain_heldout_percent")),
                                      numberOf(interval.at(0)), numberOf(interval.at(1))),
                          probabilityText(cause.at("p_adjusted")), parameters});
  }
  return table;
}

Table confusionTable(const Json& result) {
  const Json& test = result.at("self_test");
  Table table{"Self-test: what was hidden, and what was named", {"hidden"}, {}};
  for (const Json& answer : test.at("answers")) table.header.push_back(answer);
  for (std::size_t h = 0; h < test.at("hidden").size(); ++h) {
    table.rows.push_back({test.at("hidden").at(h)});
    for (const Json& count : test.at("count").at(h)) table.rows.back().push_back(count.dump());
  }
  return table;
}

}  // namespace simgap
