#include "simgap/measure/logs/actuator_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <map>

#include "simgap/core/error.h"

namespace simgap {
namespace {

struct Channel {
  const char* stem;
  const char* unit;
};

constexpr Channel kEfforts[] = {
    {"motor_current", "A"}, {"motor_voltage", "V"}, {"motor_torque", "Nm"}, {"motor_force", "N"}, {"current", "A"}};

/// The first of the channels that the table has, or null. \throws DataError: one before it has a unit that does not
/// fit.
template <std::size_t N>
const Channel* firstOf(const CsvTable& table, const Channel (&channels)[N]) {
  const auto found =
      std::ranges::find_if(channels, [&](const Channel& c) { return table.offersQuantity(c.stem, c.unit); });
  return found == std::end(channels) ? nullptr : found;
}

/// A motion channel of the motor, or of the joint times the ratio; empty when there is neither.
std::vector<double> readMotion(CsvTable& table, const char* kind, const char* unit, double ratio) {
  for (const std::string& stem : {fmt::format("motor_{}", kind), std::string(kind)}) {
    if (table.offersQuantity(stem, unit)) return table.takeQuantity(stem, unit);
  }
  const std::string joint = fmt::format("joint_{}", kind);
  if (ratio <= 0.0 || !table.offersQuantity(joint, unit)) return {};
  std::vector<double> values = table.takeQuantity(joint, unit);
  for (double& value : values) value *= ratio;
  return values;
}

std::vector<double> optional(CsvTable& table, const char* stem, const char* unit) {
  return table.offersQuantity(stem, unit) ? table.takeQuantity(stem, unit) : std::vector<double>{};
}

}  // namespace

std::vector<int> readSessions(CsvTable& table, std::vector<std::string>& names) {
  names = {"all"};
  std::vector<int> labels(table.rows(), 0);
  if (!table.has("session")) return labels;
  names.clear();
  const auto label = [&names]<typename Key>(std::map<Key, int>& known, const Key& key, const std::string& name) {
    const auto [entry, is_new] = known.try_emplace(key, static_cast<int>(names.size()));
    if (is_new) names.push_back(name);
    return entry->second;
  };
  if (table.isNumeric("session")) {
    std::map<double, int> known;
    const std::vector<double> values = table.takeQuantity("session", "");
    for (std::size_t i = 0; i < labels.size(); ++i) {
      const bool same = i > 0 && values[i] == values[i - 1];
      labels[i] = same ? labels[i - 1] : label(known, values[i], fmt::format("{}", values[i]));
    }
  } else {
    std::map<std::string, int> known;
    const std::vector<std::string> texts = table.text("session");
    for (std::size_t i = 0; i < labels.size(); ++i) labels[i] = label(known, texts[i], texts[i]);
  }
  return labels;
}

void requireRisingTime(const CsvTable& table, const std::vector<double>& time, const std::vector<int>& session) {
  for (std::size_t i = 1; i < time.size(); ++i) {
    if (session[i] != session[i - 1] || time[i] > time[i - 1]) continue;
    table.fail(i, fmt::format("time goes from {} s to {} s, expected it to rise within a session (a column `session` "
                              "separates runs that begin anew)",
                              time[i - 1], time[i]));
  }
}

ActuatorLog readActuatorLog(CsvTable table, const ActuatorLogOptions& options) {
  ActuatorLog log;
  log.file = table.name();
  if (table.rows() == 0) throw DataError(table.name() + ": found no rows, expected a log");
  const Channel* effort = firstOf(table, kEfforts);
  // The message of the strict reader lists what there is.
  if (effort == nullptr) effort = &kEfforts[0];
  log.effort = table.takeQuantity(effort->stem, effort->unit);
  log.effort_name = effort->stem;
  log.effort_unit = effort->unit;
  log.linear = table.hasQuantity("position", "m") || table.hasQuantity("velocity", "m_s") ||
               table.hasQuantity("motor_position", "m") || table.hasQuantity("motor_velocity", "m_s");
  log.velocity = readMotion(table, "velocity", log.velocityUnit(), options.ratio);
  log.position = readMotion(table, "position", log.angleUnit(), options.ratio);
  if (log.velocity.empty() && log.position.empty()) {
    const bool joint = table.hasQuantity("joint_velocity", "rad_s") || table.hasQuantity("joint_position", "rad");
    throw DataError(fmt::format(
        "{}:1: {}", table.name(),
        joint ? "found only the joint's motion, expected --ratio, or transmission_ratio of --bench, to turn it "
                "into the motor's"
              : "found no motor_velocity_rad_s and no motor_position_rad, expected one of them "
                "(--map motor_velocity_rad_s=COLUMN renames)"));
  }
  log.load = log.linear ? optional(table, "external_force", "N") : optional(table, "external_torque", "Nm");
  if (log.load.empty() && !log.linear) log.load = optional(table, "load_torque", "Nm");  // of a motor's bench
  log.session = readSessions(table, log.session_names);
  log.time = optional(table, "time", "s");
  log.has_time = !log.time.empty();
  if (log.has_time) {
    requireRisingTime(table, log.time, log.session);
  } else {
    log.time.resize(log.rows());
    for (std::size_t i = 0; i < log.rows(); ++i) log.time[i] = static_cast<double>(i) / options.row_rate;
  }
  return log;
}

MotorLog readMotorLog(CsvTable table) {
  MotorLog log;
  log.file = table.name();
  log.time = table.takeQuantity("time", "s");
  if (log.rows() < 2) throw DataError(fmt::format("{}: found {} rows, expected a log", table.name(), log.rows()));
  log.voltage = optional(table, "voltage", "V");
  log.current = optional(table, "current", "A");
  log.velocity = optional(table, "velocity", "rad_s");
  log.load = optional(table, "load_torque", "Nm");
  log.session = readSessions(table, log.session_names);
  requireRisingTime(table, log.time, log.session);
  return log;
}

namespace {

/// A muscle needs some 10 kPa to pull at all. \throws DataError: pressures that look like bar or psi
void requireMusclePressure(const std::string& file, const std::string& name, std::span<const double> pressure) {
  constexpr double kLeast = 1e3;  // [Pa]
  double largest = 0.0;
  for (const double p : pressure) largest = std::max(largest, std::abs(p));
  if (largest == 0.0 || largest >= kLeast) return;
  throw DataError(
      fmt::format("{}: {}: found at most {:.3g} Pa, expected what makes a muscle pull, 10 kPa and more: is "
                  "that the unit? (--map {}=COLUMN*1e5 for bar)",
                  file, name, largest, name));
}

}  // namespace

PamLog readPamLog(CsvTable table) {
  PamLog log;
  log.file = table.name();
  log.pressure = table.takeQuantity("pressure", "Pa");
  requireMusclePressure(log.file, "pressure_Pa", log.pressure);
  log.contraction = table.takeQuantity("contraction", "");
  log.force = table.takeQuantity("force", "N");
  if (log.rows() == 0) throw DataError(table.name() + ": found no rows, expected a log");
  log.session = readSessions(table, log.session_names);
  log.time = optional(table, "time", "s");
  if (!log.time.empty()) requireRisingTime(table, log.time, log.session);
  return log;
}

void repairSpikes(PamLog& log) {
  if (log.time.empty()) return;
  const SearchedChannel channels[] = {
      {log.of_joint ? "angle_rad" : "contraction", &log.contraction, kMotionSpikes},
      {log.opposed() ? "pressure_flexor_Pa" : "pressure_Pa", &log.pressure, kMotionSpikes},
      {"pressure_extensor_Pa", &log.opposing_pressure, kMotionSpikes},
      {log.force_column, &log.force, kEffortSpikes}};
  log.spikes = repairSpikes(log.time, log.session, channels);
  if (log.spikes.empty()) return;
  for (std::size_t i = 0; i < log.opposing_contraction.size(); ++i) {  // of the same angle
    log.opposing_contraction[i] = log.opposing_rest + log.rest - log.contraction[i];
  }
}

PamLog readJointPamLog(CsvTable table, const MusclePulley& pulley) {
  PamLog log;
  log.file = table.name();
  const bool named = table.offersQuantity("muscle_torque", "Nm");
  log.force_column = named ? "muscle_torque_Nm" : "torque_Nm";
  log.of_joint = true;
  const std::vector<double> torque = table.takeQuantity(named ? "muscle_torque" : "torque", "Nm");
  const std::vector<double> angle = table.takeQuantity("angle", "rad");
  const std::vector<double> flexor = optional(table, "pressure_flexor", "Pa");
  const std::vector<double> extensor = optional(table, "pressure_extensor", "Pa");
  if (torque.empty()) throw DataError(table.name() + ": found no rows, expected a log");
  if (flexor.empty() && extensor.empty()) {
    throw DataError(table.name() +
                    ":1: found neither pressure_flexor_Pa nor pressure_extensor_Pa, expected one at least");
  }
  requireMusclePressure(log.file, "pressure_flexor_Pa", flexor);
  requireMusclePressure(log.file, "pressure_extensor_Pa", extensor);
  const double sign = flexor.empty() ? -1.0 : 1.0, per_angle = pulley.radius / pulley.length;
  for (std::size_t i = 0; i < torque.size(); ++i) {
    const double in_flexor = pulley.rest_flexor + per_angle * angle[i];
    const double in_extensor = pulley.rest_extensor - per_angle * angle[i];
    log.force.push_back(sign * torque[i] / pulley.radius);
    log.contraction.push_back(flexor.empty() ? in_extensor : in_flexor);
    if (!flexor.empty() && !extensor.empty()) log.opposing_contraction.push_back(in_extensor);
  }
  log.rest = flexor.empty() ? pulley.rest_extensor : pulley.rest_flexor;
  log.opposing_rest = pulley.rest_extensor;
  log.pressure = flexor.empty() ? extensor : flexor;
  if (!flexor.empty()) log.opposing_pressure = extensor;
  log.session = readSessions(table, log.session_names);
  log.time = optional(table, "time", "s");
  if (!log.time.empty()) requireRisingTime(table, log.time, log.session);
  return log;
}

}  // namespace simgap
