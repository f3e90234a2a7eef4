#include "simgap/measure/logs/rig_load.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <numbers>
#include <utility>

#include "simgap/core/error.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

void addColumn(FrictionData& data, const ArrayXd& per_unit) {
  data.load_per.conservativeResize(per_unit.size(), data.load_per.cols() + 1);
  data.load_per.col(data.load_per.cols() - 1) = per_unit;
}

void addConstant(FrictionData& data, const char* name, const char* unit) {
  data.rig_names.emplace_back(name);
  data.rig_units.emplace_back(unit);
}

/// A load of constant times `per_unit`. \param value  of the constant in every row, where it is known.
void addRigTerm(FrictionData& data, bool fitted, const char* name, const char* unit, const ArrayXd& value,
                const ArrayXd& per_unit) {
  if (!fitted) {
    data.load += value * per_unit;
    return;
  }
  addColumn(data, per_unit);
  addConstant(data, name, unit);
}

/// The bench's constants of every session of the log. \throws ConfigError.
std::vector<BenchConstants> constantsOf(const ActuatorLog& log, const Bench& bench) {
  if (bench.sessions.empty()) return std::vector<BenchConstants>(log.session_names.size(), bench);
  std::vector<BenchConstants> constants;
  for (const std::string& name : log.session_names) {
    const auto found = bench.sessions.find(name);
    if (found == bench.sessions.end()) {
      std::vector<std::string> names;
      for (const auto& [other, own] : bench.sessions) names.push_back(other);
      throw ConfigError(fmt::format("{}: found no entry for session {} of {} under sessions, expected one beside {}",
                                    bench.file, name, log.file, fmt::join(names, ", ")));
    }
    constants.push_back(found->second);
  }
  return constants;
}

/// A constant in every row; 1 where it is to be fitted.
ArrayXd perRow(const ActuatorLog& log, const std::vector<BenchConstants>& sessions,
               BenchConstant BenchConstants::*constant) {
  ArrayXd values(std::ssize(log.session));
  for (Index i = 0; i < values.size(); ++i) values[i] = (sessions[log.session[i]].*constant).value;
  return values;
}

/// m g l sin(theta - theta_0) + (m l^2 + J) theta''. \param angle, acceleration  of the pendulum.
void addPendulum(const ActuatorLog& log, const Bench& bench, const ArrayXd& angle, const ArrayXd& acceleration,
                 FrictionData& data) {
  const std::vector<BenchConstants> sessions = constantsOf(log, bench);
  const ArrayXd length = perRow(log, sessions, &BenchConstants::length);
  const ArrayXd moment = perRow(log, sessions, &BenchConstants::mass) * length;  // [kg m], per unit of what is fitted
  const bool scaled = bench.length.fitted || bench.mass.fitted;
  const auto [name, unit] = bench.length.fitted ? std::pair("length", "m") : std::pair("mass", "kg");
  const ArrayXd inertial =
      bench.fitsWholeInertia() ? ArrayXd::Zero(angle.size()) : ArrayXd(moment * length * acceleration);
  if (bench.angle_offset.fitted) {
    data.fits_angle = true;
    addColumn(data, moment * bench.gravity * angle.sin());
    addColumn(data, -moment * bench.gravity * angle.cos());
    if (scaled) addConstant(data, name, unit);
    addConstant(data, "angle_offset", "rad");
    data.load += inertial;
  } else {
    data.fits_weight = bench.fitsWeight();
    const ArrayXd offset = perRow(log, sessions, &BenchConstants::angle_offset);
    addRigTerm(data, scaled, name, unit, ArrayXd::Ones(angle.size()),
               moment * bench.gravity * (angle - offset).sin() + inertial);
  }
  addRigTerm(data, bench.inertia.fitted, bench.fitsWholeInertia() ? "total_inertia" : "inertia", "kg_m2",
             perRow(log, sessions, &BenchConstants::inertia), acceleration);
}

/// A pendulum that goes round and round is one in degrees.
void warnOfTurns(const ActuatorLog& log, double ratio, FrictionData& data) {
  constexpr double kMany = 3.0;  // turns
  const auto [low, high] = std::ranges::minmax(log.position);
  const double turns = (high - low) / ratio / (2.0 * std::numbers::pi);
  if (turns < kMany) return;
  data.warnings.push_back(
      fmt::format("the pendulum turns {:.0f} times round: is its position in radians? (a position in degrees has a "
                  "column that ends "
                  "in _deg)",
                  turns));
}

void addFreeAxis(const ActuatorLog& log, const Bench& bench, const ArrayXd& acceleration, FrictionData& data) {
  const auto constant = log.linear ? &BenchConstants::mass : &BenchConstants::inertia;
  addRigTerm(data, (bench.*constant).fitted, log.linear ? "mass" : "inertia", log.linear ? "kg" : "kg_m2",
             perRow(log, constantsOf(log, bench), constant), acceleration);
}

}  // namespace

void workOutLoad(const ActuatorLog& log, const Bench& bench, FrictionData& data) {
  const Index n = std::ssize(log.session);
  const auto column = [n](const std::vector<double>& v) { return Eigen::Map<const ArrayXd>(v.data(), n); };
  data.load = ArrayXd::Zero(n);
  data.load_per.resize(n, 0);
  if (!log.load.empty()) data.load = column(log.load);
  switch (bench.load) {
    case BenchLoad::kTorqueSensor:
      if (!log.load.empty()) return;
      throw DataError(
          fmt::format("{}:1: found no {}, expected it, or --bench RIG.yaml that says where the load comes from",
                      log.file, quantityName(log.linear ? "external_force" : "external_torque", log.loadUnit())));
    case BenchLoad::kPendulum: {
      if (log.position.empty()) {
        throw DataError(log.file +
                        ":1: found no position, expected it for a pendulum: motor_position_rad, or "
                        "joint_position_rad with --ratio (1 where motor and joint turn alike)");
      }
      const double ratio = bench.ratio.value_or(1.0);
      warnOfTurns(log, ratio, data);
      addPendulum(log, bench, column(log.position) / ratio, column(log.acceleration) / ratio, data);
      return;
    }
    case BenchLoad::kFreeAxis:
      addFreeAxis(log, bench, column(log.acceleration), data);
      return;
  }
}

}  // namespace simgap
