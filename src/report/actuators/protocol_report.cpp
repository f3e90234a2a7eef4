#include "simgap/report/actuators/protocol_report.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/csv.h"
#include "simgap/core/statistics.h"

namespace simgap {
namespace {

/// What the rows of a session reach: a slow motion does not get round within its time.
struct SessionReach {
  double lower = kInfinity, upper = -kInfinity, velocity = 0.0;  ///< [rad], [rad/s]
};

std::vector<SessionReach> sessionReach(const BenchProtocol& found) {
  std::vector<SessionReach> reach(found.sessions.size());
  for (std::size_t row = 0; row < found.time.size(); ++row) {
    SessionReach& session = reach[found.session[row]];
    session.lower = std::min(session.lower, found.angle[row]);
    session.upper = std::max(session.upper, found.angle[row]);
    session.velocity = std::max(session.velocity, std::abs(found.velocity[row]));
  }
  return reach;
}

Json sessionRecords(const ProtocolReport& report) {
  Json records = Json::array();
  const std::vector<SessionReach> reach = sessionReach(report.found);
  for (std::size_t s = 0; s < report.found.sessions.size(); ++s) {
    const BenchMotion& motion = report.found.sessions[s];
    const LeverWeight& weight = report.limits.weights[motion.weight];
    const bool sine = motion.kind == BenchMotion::Kind::kSine;
    records.push_back({{"session", s},
                       {"motion", sine ? "sine" : "moves"},
                       {"mass_kg", weight.mass},
                       {"length_m", weight.length},
                       {"lower_rad", reach[s].lower},
                       {"upper_rad", reach[s].upper},
                       {"velocity_rad_s", reach[s].velocity},
                       {"acceleration_rad_s2", motion.acceleration},
                       {"rest_s", motion.rest}});
  }
  return records;
}

/// Of random protocols, the median.
double medianSd(const ProtocolReport& report, std::size_t parameter) {
  std::vector<double> values;
  for (const ProtocolPrecision& precision : report.found.random) values.push_back(precision.expected[parameter].sd);
  return upperMedian(std::move(values));
}

Json expectedRecords(const ProtocolReport& report) {
  Json records = Json::array();
  const std::vector<Estimate>& expected = report.found.precision.expected;
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Estimate& e = expected[i];
    if (!std::isfinite(e.sd)) continue;
    records.push_back({{"name", e.name},
                       {"unit", e.unit},
                       {"value", e.value},
                       {"expected_sd", e.sd},
                       {"expected_lower95", e.lower95},
                       {"expected_upper95", e.upper95},
                       {"expected_sd_random", numberOrNull(medianSd(report, i))}});
  }
  return records;
}

double largestOf(const std::vector<double>& values) {
  double largest = 0.0;
  for (const double value : values) largest = std::max(largest, std::abs(value));
  return largest;
}

}  // namespace

Json toJson(const ProtocolReport& report) {
  const BenchProtocol& found = report.found;
  std::vector<double> random;
  for (const ProtocolPrecision& precision : found.random) random.push_back(precision.log_sd);
  const double best = std::ranges::min(random);
  Json causes = Json::array();
  for (const Extension& cause : report.limits.guess.extensions) causes.push_back(cause.effect);
  return {{"format", "simgap/bench-protocol/1"},
          {"law", report.limits.guess.law},
          {"causes", causes},
          {"duration_s", report.limits.session * static_cast<double>(found.sessions.size())},
          {"session_s", report.limits.session},
          {"rate_Hz", report.limits.rate},
          {"transmission_ratio", report.limits.ratio},
          {"motions", {{"drawn", found.drawn}, {"within_limits", found.within}}},
          {"sd_ratio",
           {{"median_random", std::exp(upperMedian(random) - found.precision.log_sd)},
            {"best_random", std::exp(best - found.precision.log_sd)},
            {"protocols", random.size()}}},
          {"reached",
           {{"velocity_rad_s", largestOf(found.velocity)},
            {"torque_Nm", largestOf(found.load)},
            {"current_A", largestOf(found.current)}}},
          {"limits",
           {{"lower_rad", report.limits.lower},
            {"upper_rad", report.limits.upper},
            {"velocity_rad_s", report.limits.velocity},
            {"torque_Nm", report.limits.torque},
            {"current_A", report.limits.current}}},
          {"sessions", sessionRecords(report)},
          {"parameters", expectedRecords(report)},
          {"not_determined", found.silent}};
}

std::string protocolCsv(const ProtocolReport& report) {
  const BenchProtocol& found = report.found;
  CsvWriter csv({"time_s", "session", "joint_position_rad", "joint_velocity_rad_s", "joint_acceleration_rad_s2",
                 "external_torque_Nm", "motor_current_A"});
  for (std::size_t i = 0; i < found.time.size(); ++i) {
    csv.add(found.time[i]).add(static_cast<double>(found.session[i])).add(found.angle[i]).add(found.velocity[i]);
    csv.add(found.acceleration[i]).add(found.load[i]).add(found.current[i]).endRow();
  }
  return csv.text();
}

std::string protocolAnswer(const Json& result) {
  const Json& ratio = result.at("sd_ratio");
  const std::size_t causes = result.at("causes").size();
  return fmt::format(
      "{} sessions of {:g} s are expected to tell {}{} {:.3g} times as exactly as sessions at random within the same "
      "limits, {:.3g} times as exactly as the best of {} (geometric mean of standard deviations).",
      result.at("sessions").size(), numberOf(result.at("session_s")), result.at("law").get<std::string>(),
      causes == 0 ? "" : fmt::format(" and {} cause{}", causes, causes == 1 ? "" : "s"),
      numberOf(ratio.at("median_random")), numberOf(ratio.at("best_random")), ratio.at("protocols").dump());
}

std::vector<Table> protocolTables(const Json& result) {
  Table parameters{"Parameters, for the values given",
                   {"parameter", "unit", "value", "expected sd", "expected 95 % interval", "sd at random"},
                   {}};
  for (const Json& p : result.at("parameters")) {
    parameters.rows.push_back(
        {p.at("name"), unitTitle(p.at("unit")), numberText(p.at("value"), "{:.4g}"),
         numberText(p.at("expected_sd"), "{:.2g}"),
         numberText(p.at("expected_lower95"), "{:.4g}") + " … " + numberText(p.at("expected_upper95"), "{:.4g}"),
         numberText(p.at("expected_sd_random"), "{:.2g}")});
  }
  for (const Json& name : result.at("not_determined")) {
    parameters.rows.push_back({name, "", "", "not determined", "", ""});
  }
  Table sessions{"Sessions, in their order",
                 {"session", "motion", "mass [kg]", "lever [m]", "from … to [rad]", "speed [rad/s]", "rest [s]"},
                 {}};
  for (const Json& s : result.at("sessions")) {
    sessions.rows.push_back({s.at("session").dump(), s.at("motion"), numberText(s.at("mass_kg"), "{:.3g}"),
                             numberText(s.at("length_m"), "{:.3g}"),
                             numberText(s.at("lower_rad"), "{:.2f}") + " … " + numberText(s.at("upper_rad"), "{:.2f}"),
                             numberText(s.at("velocity_rad_s"), "{:.3g}"), numberText(s.at("rest_s"), "{:.2g}")});
  }
  sessions.folded = sessions.rows.size() > 20;
  return {std::move(parameters), std::move(sessions)};
}

std::string protocolText(const Json& result) { return answerText(protocolAnswer(result), protocolTables(result)); }

}  // namespace simgap
