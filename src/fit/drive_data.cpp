#include "simgap/fit/drive_data.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <set>

#include "simgap/core/error.h"
#include "simgap/core/units.h"
#include "simgap/measure/motion.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr double kBlocks = 80.0;                              // that a log is cut into, if they are long enough
constexpr double kShortestBlock = 4.0, kLongestBlock = 20.0;  // [s]

ArrayXd toArray(const std::vector<double>& values) {
  return Eigen::Map<const ArrayXd>(values.data(), static_cast<Index>(values.size()));
}

ArrayXd optional(const CsvTable& table, const char* stem, const char* unit) {
  return table.hasQuantity(stem, unit) ? toArray(table.quantity(stem, unit)) : ArrayXd();
}

/// Acceleration from the smoothed velocity, session by session.
ArrayXd accelerationOf(const DriveRows& rows, double bandwidth) {
  ArrayXd acceleration = ArrayXd::Zero(rows.rows());
  for (const Block& b : splitRows(rows.session, rows.session.size())) {
    if (b.size() < 4) continue;
    const std::span<const double> time(rows.time.data() + b.begin, b.size());
    const std::span<const double> speed(rows.speed.data() + b.begin, b.size());
    const std::vector<double> slope = differentiate(time, smooth(time, speed, bandwidth));
    acceleration.segment(static_cast<Index>(b.begin), static_cast<Index>(b.size())) = toArray(slope);
  }
  return acceleration;
}

/// Travel in the direction of motion since the row before, by trapezia; after a reversal since the turning point.
ArrayXd travelOf(const DriveRows& rows) {
  ArrayXd travel = ArrayXd::Zero(rows.rows());
  for (Index i = 1; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double dt = rows.session[k] == rows.session[k - 1] ? rows.time[i] - rows.time[i - 1] : 0.0;
    const double before = rows.direction[i] * rows.speed[i - 1], now = rows.direction[i] * rows.speed[i];
    if (now <= 0.0) continue;
    travel[i] = before >= 0.0 ? 0.5 * dt * (before + now) : 0.5 * dt * now * now / (now - before);
  }
  return travel;
}

/// How long the current rest lasts, or, in motion, the last one lasted [s].
ArrayXd restOf(const DriveRows& rows, double dead_band) {
  ArrayXd rest = ArrayXd::Zero(rows.rows());
  for (Index i = 1; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (rows.session[k] != rows.session[k - 1]) continue;
    const bool still = std::abs(rows.speed[i]) <= dead_band;
    const bool was_still = std::abs(rows.speed[i - 1]) <= dead_band;
    const double dt = rows.time[i] - rows.time[i - 1];
    rest[i] = !still ? rest[i - 1] : was_still ? rest[i - 1] + dt : dt;
  }
  return rest;
}

/// Where a reversal lies within the dead band is a guess of some rows, and under load the wrong sign is the largest
/// error there is: rows within the band do not count for some time before the first row that clearly moves the other
/// way.
void leaveOutUncertainReversals(const DriveRows& rows, double dead_band, std::vector<bool>& keep) {
  constexpr double kUncertain = 0.3;  // [s]
  const auto most = static_cast<Index>(std::ceil(kUncertain / rows.step));
  double last_side = 0.0;
  Index last = -1;
  for (Index i = 0; i < rows.rows(); ++i) {
    if (std::abs(rows.speed[i]) <= dead_band) continue;
    const double side = rows.speed[i] > 0.0 ? 1.0 : -1.0;
    if (last_side != 0.0 && side != last_side && rows.direction[i] == side) {
      for (Index k = std::max(last + 1, i - most); k < i; ++k) keep[static_cast<std::size_t>(k)] = false;
    }
    last_side = side;
    last = i;
  }
}

double medianStep(const DriveRows& rows) {
  std::vector<double> steps;
  for (Index i = 1; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (rows.session[k] == rows.session[k - 1]) steps.push_back(rows.time[i] - rows.time[i - 1]);
  }
  if (steps.empty()) return 1.0;
  const auto middle = steps.begin() + static_cast<std::ptrdiff_t>(steps.size() / 2);
  std::nth_element(steps.begin(), middle, steps.end());
  return *middle;
}

/// Numeric columns that no quantity of the model came from.
void addContext(const CsvTable& table, PreparedLog& log) {
  static const std::set<std::string> kKnown = {"time",           "motor_current",  "motor_voltage", "motor_torque",
                                               "motor_force",    "motor_velocity", "velocity",      "joint_velocity",
                                               "motor_position", "position",       "session",       "external_torque",
                                               "external_force"};
  DriveRows& rows = log.data.rows;
  for (const std::string& column : table.columns()) {
    const bool known = kKnown.contains(column) || kKnown.contains(splitUnit(column).stem);
    if (known || !table.isNumeric(column)) continue;
    ArrayXd values;
    try {
      values = toArray(table.quantity(column, ""));
    } catch (const DataError&) {
      continue;  // empty cells in a column nobody asked for
    }
    const double mean = values.mean(), sd = std::sqrt((values - mean).square().mean());
    if (!(sd > 1e-9 * (1.0 + std::abs(mean)))) continue;
    log.context.push_back({column, values});
    rows.context.push_back((values - mean) / sd);
  }
}

}  // namespace

PreparedLog prepareDriveData(const CsvTable& table, const Bench& bench, const DriveLogOptions& log_options,
                             FrictionDataOptions options) {
  options.all_rows = true;
  const DriveLog drive = readDriveLog(table, log_options);
  options.block_seconds = std::clamp((drive.time.back() - drive.time.front()) / kBlocks, kShortestBlock, kLongestBlock);
  const FrictionData friction = prepareFrictionData(drive, bench, options);
  PreparedLog log;
  log.file = friction.file;
  log.effort_column = quantityName(friction.effort_name, friction.effort_unit);
  log.session_names = friction.session_names;
  log.dead_band = friction.dead_band;
  log.warnings = friction.warnings;
  log.blocks = friction.blocks;
  DriveData& data = log.data;
  data.keep = friction.keep;
  data.load_unit = friction.load_unit;
  data.effort_unit = friction.effort_unit;
  data.velocity_unit = friction.velocity_unit;
  data.rig = friction.load_per;
  for (std::size_t k = 0; k < friction.rig_names.size(); ++k) {
    data.rig_parameters.push_back({friction.rig_names[k], friction.rig_units[k]});
  }
  DriveRows& rows = data.rows;
  rows.time = friction.time;
  rows.effort = friction.effort;
  rows.speed = friction.velocity;
  rows.load = friction.load;
  rows.session = friction.session;
  rows.direction = friction.direction;
  // Before the first motion the direction is unknown: those rows do not count, but every number has to be one.
  const auto first = std::find_if(rows.direction.begin(), rows.direction.end(), [](double d) { return d != 0.0; });
  std::fill(rows.direction.begin(), first, first != rows.direction.end() ? *first : 1.0);
  rows.step = medianStep(rows);
  leaveOutUncertainReversals(rows, log.dead_band, data.keep);
  rows.top_speed = rows.speed.abs().maxCoeff();
  rows.top_load = rows.load.abs().maxCoeff();
  rows.acceleration =
      accelerationOf(rows, options.bandwidth.value_or(FrictionDataOptions::kDefaultBandwidth / rows.step));
  rows.travel = travelOf(rows);
  rows.rest = restOf(rows, log.dead_band);
  rows.joint_angle = optional(table, "joint_position", "rad");
  rows.motor_angle = optional(table, "motor_position", "rad");
  if (rows.joint_angle.size() == 0 && !drive.position.empty()) {
    rows.joint_angle = toArray(drive.position) / (log_options.ratio > 0.0 ? log_options.ratio : 1.0);
  }
  rows.temperature = optional(table, "temperature", "degC");
  addContext(table, log);
  return log;
}

DriveSubject subjectOf(const FittedModel& model) {
  DriveSubject subject{&friction::find(model.law), {}, {}};
  for (const Extension& extension : model.extensions) {
    const DriveEffect& effect = drive_effects::find(extension.effect);
    subject.effects.push_back(&effect);
    for (const ExtensionParameter& p : extension.parameters) {
      const bool known =
          std::ranges::find(effect.columns, p.name, &EffectColumn::name) != effect.columns.end() ||
          std::ranges::find(effect.parameters, p.name, &EffectParameter::name) != effect.parameters.end();
      if (!known) {
        throw ConfigError(fmt::format("found the parameter {} in the extension {}, which has none of that name", p.name,
                                      effect.name));
      }
      subject.values.push_back({fmt::format("{}.{}", effect.name, p.name), p.unit, p.value, p.sd, false});
    }
    for (const EffectColumn& column : effect.columns) static_cast<void>(extension.value(column.name));
    for (const EffectParameter& p : effect.parameters) static_cast<void>(extension.value(p.name));
  }
  for (const FittedParameter& p : model.parameters) subject.values.push_back({p.name, p.unit, p.value, p.sd, p.fixed});
  return subject;
}

Eigen::ArrayXd predictExtended(const DriveSubject& subject, const DriveData& data) {
  const DriveRegression regression(*subject.law, subject.effects, data, std::nullopt);
  return regression.predict(regression.thetaOf(subject.values));
}

}  // namespace simgap
