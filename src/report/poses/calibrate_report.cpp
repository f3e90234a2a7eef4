#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "calibrate_uncertainty.h"
#include "pose_tables.h"
#include "simgap/core/joint_kind.h"

namespace simgap {
namespace {

constexpr std::size_t kMostFailed = 5;  // poses that did not come to rest, on a terminal

const std::vector<double>& bestValues(const CalibrationResult& result) { return result.state.strategy.best.y; }

/// What is known of a parameter; nothing when no pose was at rest.
const ParameterUncertainty* uncertaintyOf(const CalibrationResult& result, std::size_t parameter) {
  return result.uncertainty ? &result.uncertainty->parameters[parameter] : nullptr;
}

Json parametersJson(const CalibrationResult& result) {
  Json parameters = Json::array();
  for (std::size_t i = 0; i < result.parameters.size(); ++i) {
    const SearchParameter& p = result.parameters[i];
    const ParameterUncertainty* known = uncertaintyOf(result, i);
    const double value = bestValues(result)[i];
    parameters.push_back({{"name", p.name},
                          {"unit", p.unit},
                          {"initial", p.initial},
                          {"value", value},
                          {"sd", known ? numberOrNull(known->sd) : Json(nullptr)},
                          {"prior_sd", known ? numberOrNull(known->prior_sd) : Json(nullptr)},
                          {"lower", numberOrNull(p.lower)},
                          {"upper", numberOrNull(p.upper)},
                          {"at_bound", value <= p.lower || value >= p.upper},
                          {"identifiable", known ? Json(toString(known->verdict)) : Json(nullptr)}});
  }
  return parameters;
}

}  // namespace

Json toJson(const CalibrationResult& result) {
  Json mje = Json::object(), valid = Json::object();
  for (const SetResult& set : result.sets) {
    const ComparedErrors errors = compareErrors(set, result.layout.joints.size());
    for (const std::string& unit : errorUnits(result.layout)) {
      const auto both = [&](const std::vector<double>& before, const std::vector<double>& after) -> Json {
        return {{"initial", mjeJson(result.layout, before, unit)}, {"final", mjeJson(result.layout, after, unit)}};
      };
      mje["mje_" + unit][set.name] = both(errors.before, errors.after);
      mje["paper_mje_" + unit][set.name] =
          both(paperAngles(result.layout, errors.before), paperAngles(result.layout, errors.after));
    }
    valid[set.name] = {{"initial", set.initial.valid},
                       {"final", set.final.valid},
                       {"compared", errors.poses},
                       {"of", set.set.poses.size()}};
  }
  const Delivery delivery = judgeDelivery(result);
  Json json = {{"format", "simgap/calibrate/1"},
               {"delivered", delivery.calibrated ? "calibrated" : "start"},
               {"failure", delivery.failure.empty() ? Json(nullptr) : Json(delivery.failure)},
               {"optimizer", result.config.optimizer},
               {"evaluator", result.config.evaluator},
               {"objective", result.config.usesPosterior() ? "posterior" : toString(result.config.objective)},
               {"mje_deg", mje.at("mje_deg")},
               {"paper_mje_deg", mje.at("paper_mje_deg")},
               {"valid_poses", valid},
               {"capture_sd_deg", toDegrees(result.config.noise.capture_sd)},
               {"fitness",
                {{"initial", numberOrNull(result.sets.front().initial.fitness)},
                 {"final", numberOrNull(result.sets.front().final.fitness)}}},
               {"generations", result.state.strategy.generation},
               {"evaluations", result.state.evaluations},
               {"invalid", result.state.invalid},
               {"wall_s", result.state.wall},
               {"stop_reason", toString(result.state.strategy.stop)},
               {"seed", result.config.strategy.seed},
               {"parameters", parametersJson(result)}};
  json.update(mje);
  json.update(verificationJson(result));
  json.update(uncertaintyJson(result));
  return json;
}

std::string historyCsv(const CalibrationResult& result) {
  std::vector<std::string> header{"generation", "best_rad2",    "median_rad2", "best_so_far_rad2",
                                  "sigma_min",  "sigma_median", "sigma_max",   "invalid"};
  for (const JointChannel& joint : result.layout.joints)
    header.push_back(fmt::format("mje_{}_{}", joint.name, kindOf(joint.type).error_unit));
  CsvWriter csv(header);
  const auto number = [&csv](double value) { std::isfinite(value) ? csv.add(value) : csv.add(""); };
  for (const GenerationRecord& r : result.state.history) {
    csv.add(r.generation);
    for (const double fitness : {r.best, r.median, r.best_so_far}) number(fitness);
    csv.add(r.sigma_min).add(r.sigma_median).add(r.sigma_max).add(r.invalid);
    for (std::size_t j = 0; j < r.mje.size(); ++j) number(kindOf(result.layout.joints[j].type).shown(r.mje[j]));
    csv.endRow();
  }
  return csv.text();
}

std::string parametersCsv(const CalibrationResult& result) {
  return csvText(recordTable(
      "parameters", parametersJson(result),
      {"name", "unit", "initial", "prior_sd", "value", "sd", "identifiable", "lower", "upper", "at_bound"}));
}

std::string errorsCsv(const CalibrationResult& result) {
  std::vector<std::string> header{"set", "pose", "status_before", "status_after"};
  for (const JointChannel& joint : result.layout.joints) {
    for (const char* when : {"before", "after"}) {
      header.push_back(fmt::format("{}_error_{}_{}", joint.name, when, kindOf(joint.type).error_unit));
    }
  }
  header.push_back("slack_muscles_after");
  CsvWriter csv(header);
  const auto error = [&](const std::vector<double>& errors, std::size_t joint) {
    errors.empty() ? csv.add("") : csv.add(kindOf(result.layout.joints[joint].type).shown(errors[joint]));
  };
  for (const SetResult& set : result.sets) {
    for (std::size_t p = 0; p < set.set.poses.size(); ++p) {
      csv.add(set.name).add(set.set.poses[p].name);
      csv.add(toString(set.initial.outcomes[p].status)).add(toString(set.final.outcomes[p].status));
      for (std::size_t j = 0; j < result.layout.joints.size(); ++j) {
        error(set.initial.errors[p], j);
        error(set.final.errors[p], j);
      }
      csv.add(slackText(set.final.outcomes[p], result.layout)).endRow();
    }
  }
  return csv.text();
}

std::string terminalTable(const CalibrationResult& result) {
  const Json json = toJson(result);
  std::string text = alignedTable(calibrationErrors(json));
  for (const SetResult& set : result.sets) {
    const std::vector<std::string> invalid = invalidPoses(set.final, set.set, result.layout);
    for (std::size_t i = 0; i < std::min(invalid.size(), kMostFailed); ++i) {
      text += fmt::format("{} pose {}\n", set.name, invalid[i]);
    }
    if (invalid.size() > kMostFailed) {
      text += fmt::format("and {} more {} poses: see errors.csv\n", invalid.size() - kMostFailed, set.name);
    }
  }
  const std::size_t unknowns = result.parameters.size();
  std::size_t numbers = 0;
  for (const JointChannel& joint : result.layout.joints) {
    numbers += result.sets.front().set.poses.size() * kindOf(joint.type).degrees_of_freedom;
  }
  if (numbers < unknowns) {
    text += fmt::format(
        "{} measured numbers for {} parameters: the calibration error alone proves nothing, only poses it has not "
        "seen do.\n",
        numbers, unknowns);
  }
  if (json.contains("verification")) {
    const Table both = verificationTable(json);
    text += both.caption + "\n" + alignedTable(both);
  }
  text += uncertaintyText(json);
  if (const std::string doubt = notConverged(json); !doubt.empty()) text += doubt + "\n";
  for (const std::string& surprise : surprises(json)) text += surprise + "\n";
  return text;
}

}  // namespace simgap
