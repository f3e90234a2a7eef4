#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/report/html/result_files.h"
#include "simgap/report/runs/run_comparison.h"
#include "simgap/report/table.h"

namespace simgap {
namespace {

/// What a command calls its errors; whatever stands below them is a number with a dotted name.
constexpr const char* kErrors[] = {"mje_deg",     "mje_mm",   "motion_rms", "mse",
                                   "mse_heldout", "baseline", "extended",   "left_over"};

void flatten(const std::string& name, const Json& value, std::vector<std::pair<std::string, double>>& errors) {
  if (value.is_number()) {
    errors.emplace_back(name, value.get<double>());
  } else if (value.is_object()) {
    for (const auto& [key, below] : value.items()) flatten(name + "." + key, below, errors);
  }
}

/// Returns whether the parameter has an interval.
/// \param sd  of the curvature; the interval may reach further, and to one side only, where several valleys fit
bool add(const std::string& name, const Json& parameter, double sd, std::vector<RunParameter>& parameters) {
  const double value = numberOf(parameter.at("value"));
  const Json interval = parameter.value("ci95", Json::array());
  for (const Json& end : interval) {
    const double away = std::abs(numberOf(end) - value) / kNormalQuantile;
    if (std::isfinite(away)) sd = std::max(sd, away);
  }
  if (!std::isfinite(value) || !std::isfinite(sd) || sd <= 0.0) return false;
  parameters.push_back({name, parameter.value("unit", ""), {value, sd}});
  return true;
}

RunCause readCause(const Json& cause, std::vector<RunParameter>& parameters) {
  RunCause read;
  read.name = cause.at("effect").get<std::string>();
  for (const char* where : {"target", "channel"}) {
    const std::string place = cellText(cause.value(where, Json("")));
    if (!place.empty()) read.name += ":" + place;
  }
  read.gain = numberOf(cause.value("gain_heldout_percent", Json(nullptr)));
  for (const Json& p : cause.value("parameters", Json::array())) {
    const std::string name = p.at("name").get<std::string>();
    read.magnitude +=
        fmt::format("{}{} {}", read.magnitude.empty() ? "" : ", ", name, numberText(p.at("value"), "{:.4g}"));
    if (p.value("ci95", Json::array()).size() == 2) add(read.name + "." + name, p, 0.0, parameters);
  }
  return read;
}

RunFigures figuresOf(const ResultFiles& files) {
  RunFigures run;
  const Json& result = files.result();
  run.name = files.directory().lexically_normal().string();
  if (run.name.ends_with('/')) run.name.pop_back();
  run.format = result.at("format").get<std::string>();
  run.start = files.run().value("start", "");
  run.subject = cellText(result.value("model", Json("")));
  run.verdict = cellText(result.value("verdict", Json("")));
  for (const Json& input : files.run().value("inputs", Json::array())) {
    const std::string role = input.value("role", "");
    if (role == "log" || role == "poses" || role == "motions") run.data.push_back(input.value("sha256", ""));
  }
  for (const char* name : kErrors) {
    if (result.contains(name)) flatten(name, result.at(name), run.errors);
  }
  for (const Json& p : result.value("parameters", Json::array())) {
    if (p.value("fixed", false)) continue;
    const std::string name = p.at("name").get<std::string>();
    const bool known =
        !p.value("at_bound", false) && add(name, p, numberOf(p.value("sd", Json(nullptr))), run.parameters);
    if (!known) run.without_interval.push_back(name);
  }
  for (const Json& cause : result.value("causes", Json::array())) {
    run.causes.push_back(readCause(cause, run.parameters));
  }
  return run;
}

}  // namespace

RunFigures readRun(const std::filesystem::path& directory) {
  const ResultFiles files(directory);
  if (const std::string status = cellText(files.run().value("status", Json(""))); status.starts_with("failed")) {
    throw DataError(fmt::format("{}: the run {}, expected one that is done: what it found it does not deliver",
                                directory.string(), status));
  }
  try {
    return figuresOf(files);
  } catch (const Json::exception& error) {
    throw DataError(fmt::format("{}: found no result that simgap has written: {}", (directory / "result.json").string(),
                                error.what()));
  }
}

}  // namespace simgap
