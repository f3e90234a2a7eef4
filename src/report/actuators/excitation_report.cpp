#include "simgap/report/actuators/excitation_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

const Joint& jointOf(const ExcitationReport& report, const InverseDynamics& dynamics, std::size_t c) {
  return report.robot.joints[dynamics.joints()[c]];
}

/// Calls row(time, motion) for every row of all periods, the last one at rest again.
template <class Row>
void forRows(const ExcitationReport& report, const Row& row) {
  const double length = report.limits.duration * report.limits.periods;
  const auto rows = static_cast<std::size_t>(std::llround(report.limits.rate * length));
  RobotMotion motion;
  for (std::size_t i = 0; i <= rows; ++i) {
    const double time = static_cast<double>(i) / report.limits.rate;
    report.found.motion.at(time, motion);
    row(time, motion);
  }
}

std::vector<double> rowOf(const Eigen::MatrixXd& matrix, std::size_t row) {
  const Eigen::VectorXd values = matrix.row(row);
  return {values.begin(), values.end()};
}

Json jointRecords(const ExcitationReport& report, const InverseDynamics& dynamics) {
  Json records = Json::array();
  for (std::size_t c = 0; c < report.limits.joints.size(); ++c) {
    const Joint& joint = jointOf(report, dynamics, c);
    const JointExcursion& reached = report.found.reached[c];
    const JointExcitationLimits& limits = report.limits.joints[c];
    records.push_back({{"name", joint.name},
                       {"unit", kindOf(joint.type).unit},
                       {"lower", reached.lower},
                       {"upper", reached.upper},
                       {"velocity", reached.velocity},
                       {"acceleration", reached.acceleration},
                       {"effort", reached.effort},
                       {"limits",
                        {{"lower", limits.lower},
                         {"upper", limits.upper},
                         {"velocity", limits.velocity},
                         {"acceleration", limits.acceleration},
                         {"effort", numberOrNull(limits.effort)}}},
                       {"start", report.found.motion.start()[c]},
                       {"cosines", rowOf(report.found.motion.cosines(), c)},
                       {"sines", rowOf(report.found.motion.sines(), c)}});
  }
  return records;
}

/// Median over the drawn motions, NaN where there is none.
template <class Value>
double medianOfRandom(const ExcitationReport& report, const Value& value) {
  std::vector<double> values;
  for (const ExcitationPrecision& precision : report.found.random) values.push_back(value(precision));
  return values.empty() ? std::nan("") : upperMedian(std::move(values));
}

}  // namespace

Json toJson(const ExcitationReport& report) {
  const InverseDynamics dynamics(report.robot);
  const Excitation& found = report.found;
  Json parameters = Json::array(), distances = Json::array();
  for (Eigen::Index k = 0; k < found.precision.sd.size(); ++k) {
    const double random = medianOfRandom(report, [k](const ExcitationPrecision& precision) { return precision.sd[k]; });
    parameters.push_back({{"name", found.names[k]},
                          {"unit", found.units[k]},
                          {"expected_sd", found.precision.sd[k]},
                          {"expected_sd_random", numberOrNull(random)}});
  }
  for (std::size_t d = 0; d < found.nearest.size(); ++d) {
    const DistanceLimit& limit = report.limits.distances[d];
    distances.push_back({{"name", limit.name}, {"nearest_m", found.nearest[d]}, {"at_least_m", limit.least}});
  }
  double best_random = kInfinity;
  for (const ExcitationPrecision& precision : found.random) best_random = std::min(best_random, precision.log_sd);
  const double median = medianOfRandom(report, [](const ExcitationPrecision& precision) { return precision.log_sd; });
  const double condition =
      medianOfRandom(report, [](const ExcitationPrecision& precision) { return precision.condition; });
  return {{"format", "simgap/excitation/1"},
          {"robot", report.robot.name},
          {"law", report.law},
          {"asked_for", report.limits.payload.empty() ? "base parameters" : "payload of " + report.limits.payload},
          {"duration_s", report.limits.duration},
          {"periods", report.limits.periods},
          {"rate_Hz", report.limits.rate},
          {"harmonics", report.limits.harmonics},
          {"random", {{"drawn", found.random_drawn}, {"within_limits", found.random.size()}}},
          {"sd_ratio",
           {{"median_random", numberOrNull(std::exp(median - found.precision.log_sd))},
            {"best_random", numberOrNull(std::exp(best_random - found.precision.log_sd))}}},
          {"condition", {{"found", found.precision.condition}, {"median_random", numberOrNull(condition)}}},
          {"joints", jointRecords(report, dynamics)},
          {"distances", distances},
          {"parameters", parameters}};
}

std::string trajectoryCsv(const ExcitationReport& report) {
  const InverseDynamics dynamics(report.robot);
  std::vector<std::string> header{"time_s"};
  for (std::size_t c = 0; c < report.limits.joints.size(); ++c) {
    const Joint& joint = jointOf(report, dynamics, c);
    const std::string_view unit = kindOf(joint.type).unit;
    header.push_back(fmt::format("{}_{}", joint.name, unit));
    header.push_back(fmt::format("{}_velocity_{}_s", joint.name, unit));
    header.push_back(fmt::format("{}_acceleration_{}_s2", joint.name, unit));
  }
  CsvWriter csv(header);
  forRows(report, [&](double time, const RobotMotion& motion) {
    csv.add(time);
    for (std::size_t c = 0; c < motion.position.size(); ++c) {
      csv.add(motion.position[c]).add(motion.velocity[c]).add(motion.acceleration[c]);
    }
    csv.endRow();
  });
  return csv.text();
}

Json rosTrajectory(const ExcitationReport& report) {
  const InverseDynamics dynamics(report.robot);
  Json names = Json::array(), points = Json::array();
  for (std::size_t c = 0; c < report.limits.joints.size(); ++c) names.push_back(jointOf(report, dynamics, c).name);
  forRows(report, [&](double time, const RobotMotion& motion) {
    const auto nanoseconds = static_cast<long>(std::llround(1e9 * time));
    points.push_back({{"positions", motion.position},
                      {"velocities", motion.velocity},
                      {"accelerations", motion.acceleration},
                      {"time_from_start", {{"sec", nanoseconds / 1000000000}, {"nanosec", nanoseconds % 1000000000}}}});
  });
  return {{"joint_names", names}, {"points", points}};
}

std::string excitationAnswer(const Json& result) {
  const double ratio = numberOf(result.at("sd_ratio").at("median_random"));
  const std::string asked = result.at("asked_for");
  if (!std::isfinite(ratio)) {
    return fmt::format("A motion within the limits was found; none of {} drawn at random keeps them.",
                       result.at("random").at("drawn").dump());
  }
  return fmt::format(
      "This motion is expected to tell the {} {:.3g} times as exactly as a motion at random, {:.3g} times as exactly "
      "as "
      "the best of {} (geometric mean of standard deviations).",
      asked, ratio, numberOf(result.at("sd_ratio").at("best_random")), result.at("random").at("within_limits").dump());
}

std::vector<Table> excitationTables(const Json& result) {
  Table joints{
      "Joints: how far they go, of what they may", {"joint", "range", "within", "speed", "acceleration", "effort"}, {}};
  for (const Json& joint : result.at("joints")) {
    const Json& limits = joint.at("limits");
    const auto of = [&](const char* key) {
      const std::string limit = numberText(limits.at(key), "{:.3g}");
      return numberText(joint.at(key), "{:.3g}") + (limit == "-" ? "" : " of " + limit);
    };
    const auto range = [](const Json& of_joint) {
      return numberText(of_joint.at("lower"), "{:.3g}") + " … " + numberText(of_joint.at("upper"), "{:.3g}");
    };
    joints.rows.push_back(
        {joint.at("name"), range(joint), range(limits), of("velocity"), of("acceleration"), of("effort")});
  }
  std::vector<Table> tables{std::move(joints)};
  if (!result.at("distances").empty()) {
    Table distances{"Distances [m]", {"of", "nearest", "at least"}, {}};
    for (const Json& distance : result.at("distances")) {
      distances.rows.push_back({distance.at("name"), numberText(distance.at("nearest_m"), "{:.3f}"),
                                numberText(distance.at("at_least_m"), "{:.3f}")});
    }
    tables.push_back(std::move(distances));
  }
  Table parameters{"Expected standard deviations", {"parameter", "this motion", "at random (median)", "unit"}, {}};
  for (const Json& parameter : result.at("parameters")) {
    parameters.rows.push_back({parameter.at("name"), numberText(parameter.at("expected_sd"), "{:.3g}"),
                               numberText(parameter.at("expected_sd_random"), "{:.3g}"),
                               unitTitle(parameter.at("unit"))});
  }
  parameters.folded = true;
  tables.push_back(std::move(parameters));
  return tables;
}

std::string excitationText(const Json& result) {
  return answerText(excitationAnswer(result), excitationTables(result));
}

}  // namespace simgap
