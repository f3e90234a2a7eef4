#include "simgap/report/runs/run_comparison.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "simgap/core/csv.h"
#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/report/table.h"

namespace simgap {
namespace {

constexpr double kLevel = 0.05;

/// A parameter as the runs that have it estimate it.
struct Shared {
  std::string name, unit;
  std::vector<std::size_t> runs;
  std::vector<GroupEstimate> estimates;  ///< shape (runs)
};

std::vector<Shared> sharedParameters(const std::vector<RunFigures>& runs) {
  std::vector<Shared> shared;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (const RunParameter& p : runs[r].parameters) {
      auto at = std::ranges::find(shared, p.name, &Shared::name);
      if (at == shared.end()) at = shared.insert(at, {p.name, p.unit, {}, {}});
      at->runs.push_back(r);
      at->estimates.push_back(p.estimate);
    }
  }
  std::erase_if(shared, [](const Shared& s) { return s.runs.size() < 2; });
  return shared;
}

Json finiteOrNull(double value) { return std::isfinite(value) ? Json(value) : Json(nullptr); }

Json parameterJson(const Shared& shared, const PooledEstimate& pooled, const std::vector<RunFigures>& runs) {
  Json values = Json::array();
  for (std::size_t i = 0; i < shared.runs.size(); ++i) {
    const GroupEstimate &own = shared.estimates[i], &drawn = pooled.groups[i];
    values.push_back({{"run", runs[shared.runs[i]].name},
                      {"value", own.value},
                      {"sd", own.sd},
                      {"pooled", drawn.value},
                      {"pooled_sd", drawn.sd},
                      {"off_sd", (own.value - pooled.mean) / std::hypot(own.sd, pooled.scatter)}});
  }
  return {{"name", shared.name},       {"unit", shared.unit},
          {"common", pooled.mean},     {"common_ci95", {pooled.mean_lower, pooled.mean_upper}},
          {"scatter", pooled.scatter}, {"scatter_ci95", {pooled.scatter_lower, pooled.scatter_upper}},
          {"p_equal", pooled.p_equal}, {"p_adjusted", nullptr},
          {"verdict", "same"},         {"change", nullptr},
          {"drift", nullptr},          {"runs", values}};
}

Json changeJson(const ChangePoint& change, const Json& values) {
  const double half = kNormalQuantile * change.step.sd;
  return {{"since", values[change.first].at("run")},
          {"earliest", values[change.earliest].at("run")},
          {"latest", values[change.latest].at("run")},
          {"step", change.step.value},
          {"step_ci95", {change.step.value - half, change.step.value + half}},
          {"p_adjusted", change.p}};
}

Json driftJson(const Drift& drift, double p) {
  const double half = kNormalQuantile * drift.slope.sd;
  return {{"per_run", drift.slope.value},
          {"per_run_ci95", {drift.slope.value - half, drift.slope.value + half}},
          {"p_adjusted", p}};
}

/// Two gates, each at 5 % over all that pass the one before: what differs, and what of it changed at one time or
/// drifts.
void judge(const std::vector<Shared>& shared, Json& parameters) {
  std::vector<double> p;
  for (const Json& parameter : parameters) p.push_back(parameter.at("p_equal").get<double>());
  const std::vector<double> adjusted = holmAdjusted(p);
  std::vector<std::size_t> tested;
  std::vector<ChangePoint> changes;
  std::vector<Drift> drifts;
  std::vector<double> p_in_time;  // of each the change's, then the drift's
  for (std::size_t i = 0; i < shared.size(); ++i) {
    parameters[i]["p_adjusted"] = adjusted[i];
    if (adjusted[i] >= kLevel) continue;
    parameters[i]["verdict"] = "differs";
    const auto change = findChange(shared[i].estimates);
    if (!change) continue;
    tested.push_back(i);
    changes.push_back(*change);
    drifts.push_back(*findDrift(shared[i].estimates));
    p_in_time.insert(p_in_time.end(), {change->p, drifts.back().p});
  }
  const std::vector<double> adjusted_in_time = holmAdjusted(p_in_time);
  for (std::size_t k = 0; k < tested.size(); ++k) {
    Json& parameter = parameters[tested[k]];
    const double p_change = adjusted_in_time[2 * k], p_drift = adjusted_in_time[2 * k + 1];
    if (p_change < kLevel) {
      parameter["verdict"] = "changed";
      changes[k].p = p_change;
      parameter["change"] = changeJson(changes[k], parameter.at("runs"));
    } else if (p_drift < kLevel) {
      parameter["verdict"] = "drifts";
      parameter["drift"] = driftJson(drifts[k], p_drift);
    }
  }
}

Json errorsJson(const std::vector<RunFigures>& runs) {
  std::vector<std::string> names;
  for (const RunFigures& run : runs) {
    for (const auto& [name, value] : run.errors) {
      if (std::ranges::find(names, name) == names.end()) names.push_back(name);
    }
  }
  Json errors = Json::array();
  for (const std::string& name : names) {
    Json values = Json::array();
    for (const RunFigures& run : runs) {
      const auto at = std::ranges::find(run.errors, name, &std::pair<std::string, double>::first);
      values.push_back(at == run.errors.end() ? Json(nullptr) : finiteOrNull(at->second));
    }
    errors.push_back({{"name", name}, {"values", values}});
  }
  return errors;
}

Json causesJson(const std::vector<RunFigures>& runs) {
  std::map<std::string, Json> causes;
  for (std::size_t r = 0; r < runs.size(); ++r) {
    for (const RunCause& cause : runs[r].causes) {
      Json& entry = causes.try_emplace(cause.name, Json{{"cause", cause.name}, {"runs", Json::array()}}).first->second;
      entry["runs"].push_back(
          {{"run", runs[r].name}, {"gain_heldout_percent", finiteOrNull(cause.gain)}, {"magnitude", cause.magnitude}});
    }
  }
  Json list = Json::array();
  for (auto& [name, entry] : causes) list.push_back(std::move(entry));
  return list;
}

/// Parameters that some runs estimate and others could not: what differs most may be among them.
std::vector<std::string> partlyKnown(const std::vector<RunFigures>& runs) {
  std::vector<std::string> names;
  for (const RunFigures& run : runs) {
    for (const std::string& name : run.without_interval) {
      const bool elsewhere = std::ranges::any_of(runs, [&](const RunFigures& other) {
        return std::ranges::find(other.parameters, name, &RunParameter::name) != other.parameters.end();
      });
      if (elsewhere && std::ranges::find(names, name) == names.end()) names.push_back(name);
    }
  }
  return names;
}

/// \param partly  parameters that only some of them know
Json warningsOf(const std::vector<RunFigures>& runs, const std::vector<std::string>& partly) {
  Json warnings = Json::array();
  for (const std::string& name : partly) {
    std::vector<std::string> where;
    for (const RunFigures& run : runs) {
      if (std::ranges::find(run.without_interval, name) != run.without_interval.end()) where.push_back(run.name);
    }
    warnings.push_back(fmt::format("{} is at a bound or not determined in {}, and so not compared with it", name,
                                   fmt::join(where, ", ")));
  }
  for (std::size_t a = 0; a < runs.size(); ++a) {
    for (std::size_t b = 0; b < a; ++b) {
      const bool same = std::ranges::find_first_of(runs[a].data, runs[b].data) != runs[a].data.end();
      if (!same) continue;
      warnings.push_back(fmt::format(
          "{} and {} read the same data: their differences are smaller than chance's, and no test of them holds",
          runs[b].name, runs[a].name));
    }
    if (runs[a].subject != runs[0].subject) {
      warnings.push_back(fmt::format("{} fits {}, {} fits {}: a parameter of one name may mean another thing",
                                     runs[0].name, runs[0].subject, runs[a].name, runs[a].subject));
    }
  }
  return warnings;
}

}  // namespace

Json compareRuns(const std::vector<RunFigures>& runs) {
  Json described = Json::array();
  for (const RunFigures& run : runs) {
    if (run.format != runs[0].format) {
      throw DataError(fmt::format("found {} of {} and {} of {}, expected runs of one command", runs[0].format,
                                  runs[0].name, run.format, run.name));
    }
    described.push_back({{"name", run.name}, {"start", run.start}, {"model", run.subject}, {"verdict", run.verdict}});
  }
  const std::vector<Shared> shared = sharedParameters(runs);
  Json parameters = Json::array();
  for (const Shared& s : shared) parameters.push_back(parameterJson(s, pool(s.estimates), runs));
  judge(shared, parameters);
  const std::vector<std::string> partly = partlyKnown(runs);
  return {{"format", "simgap/compare/1"},
          {"compared", runs[0].format},
          {"runs", described},
          {"errors", errorsJson(runs)},
          {"parameters", parameters},
          {"causes", causesJson(runs)},
          {"partly_known", partly},
          {"warnings", warningsOf(runs, partly)}};
}

std::string comparisonAnswer(const Json& result) {
  std::string words;
  std::size_t differing = 0;
  for (const Json& p : result.at("parameters")) {
    if (p.at("verdict") == "same") continue;
    ++differing;
    const Json &change = p.at("change"), drift = p.value("drift", Json());  // which files of before have not
    const std::string unit = unitTitle(p.at("unit").get<std::string>());
    words += (words.empty() ? "" : "; ") + p.at("name").get<std::string>();
    if (!change.is_null()) {
      words += fmt::format(" changed by {} {} since {}", numberText(change.at("step"), "{:+.3g}"), unit,
                           cellText(change.at("since")));
    } else if (!drift.is_null()) {
      words += fmt::format(" drifts by {} {} from run to run", numberText(drift.at("per_run"), "{:+.3g}"), unit);
    } else {
      words += fmt::format(" scatters by {} {}", numberText(p.at("scatter"), "{:.2g}"), unit);
    }
  }
  const std::size_t all = result.at("parameters").size(), runs = result.at("runs").size();
  if (all == 0) return fmt::format("{} runs, no parameter with an interval in two of them.", runs);
  if (differing == 0) {
    const std::size_t partly = result.value("partly_known", Json::array()).size();
    return fmt::format("{} runs agree{}: none of {} parameters differs by more than its interval allows.", runs,
                       partly == 0 ? "" : fmt::format(" in what all know, and {} more cannot be compared", partly),
                       all);
  }
  return fmt::format("{} of {} parameters differ between {} runs: {}.", differing, all, runs, words);
}

std::string comparisonText(const Json& result) {
  std::string text = comparisonAnswer(result) + "\n";
  std::vector<std::string> header{"error"};
  for (const Json& run : result.at("runs")) header.push_back(cellText(run.at("name")));
  std::vector<std::vector<std::string>> errors{header};
  for (const Json& error : result.at("errors")) {
    errors.push_back({cellText(error.at("name"))});
    for (const Json& value : error.at("values")) errors.back().push_back(numberText(value, "{:.4g}"));
  }
  if (errors.size() > 1) text += "\n" + alignedTable(errors);
  std::vector<std::vector<std::string>> rows{
      {"parameter", "unit", "common", "95 % interval", "scatter", "p", "verdict"}};
  for (const Json& p : result.at("parameters")) {
    rows.push_back({cellText(p.at("name")), unitTitle(cellText(p.at("unit"))), numberText(p.at("common"), "{:.4g}"),
                    fmt::format("{} to {}", numberText(p.at("common_ci95")[0], "{:.4g}"),
                                numberText(p.at("common_ci95")[1], "{:.4g}")),
                    numberText(p.at("scatter"), "{:.2g}"), probabilityText(p.at("p_adjusted")),
                    cellText(p.at("verdict"))});
  }
  if (rows.size() > 1) text += "\n" + alignedTable(rows);
  std::vector<std::vector<std::string>> causes{{"cause", "run", "gain %", "magnitude"}};
  for (const Json& cause : result.at("causes")) {
    for (const Json& run : cause.at("runs")) {
      causes.push_back({cellText(cause.at("cause")), cellText(run.at("run")),
                        numberText(run.at("gain_heldout_percent"), "{:.1f}"), cellText(run.at("magnitude"))});
    }
  }
  if (causes.size() > 1) text += "\n" + alignedTable(causes);
  for (const Json& warning : result.at("warnings")) text += "WARNING: " + cellText(warning) + "\n";
  return text;
}

std::string comparisonCsv(const Json& result) {
  CsvWriter csv({"parameter", "unit", "run", "value", "sd", "pooled", "pooled_sd", "off_sd"});
  for (const Json& p : result.at("parameters")) {
    for (const Json& run : p.at("runs")) {
      csv.add(cellText(p.at("name"))).add(cellText(p.at("unit"))).add(cellText(run.at("run")));
      for (const char* key : {"value", "sd", "pooled", "pooled_sd", "off_sd"}) csv.add(numberOf(run.at(key)));
      csv.endRow();
    }
  }
  return csv.text();
}

}  // namespace simgap
