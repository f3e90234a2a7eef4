#include "simgap/measure/logs/prepared_log.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numeric>
#include <set>

#include "simgap/core/error.h"
#include "simgap/core/statistics.h"
#include "simgap/core/units.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/measure/logs/spring_log.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr double kBlocks = 80.0;                              // that a log is cut into, if they are long enough
constexpr double kShortestBlock = 4.0, kLongestBlock = 20.0;  // [s]
constexpr double kFewestBlocks = 40.0;                        // of a log so short that blocks have to be shorter
constexpr double kFewestRows = 50.0;                          // per block

ArrayXd toArray(const std::vector<double>& values) { return Eigen::Map<const ArrayXd>(values.data(), values.size()); }

ArrayXd optional(const CsvTable& table, const char* stem, const char* unit) {
  return table.hasQuantity(stem, unit) ? toArray(table.quantity(stem, unit)) : ArrayXd();
}

/// d values / dt of the smoothed values, session by session.
ArrayXd slopeOf(const ActuatorRows& rows, const ArrayXd& values, double bandwidth) {
  ArrayXd slopes = ArrayXd::Zero(rows.rows());
  for (const Block& b : splitRows(rows.session, rows.session.size())) {
    if (b.size() < 4) continue;
    const std::span<const double> time(rows.time.data() + b.begin, b.size());
    const std::span<const double> part(values.data() + b.begin, b.size());
    const std::vector<double> slope = differentiate(time, smooth(time, part, bandwidth));
    slopes.segment(b.begin, b.size()) = toArray(slope);
  }
  return slopes;
}

/// Travel in the direction of motion since the row before, by trapezia; after a reversal since the turning point.
ArrayXd travelOf(const ActuatorRows& rows) {
  ArrayXd travel = ArrayXd::Zero(rows.rows());
  for (Index i = 1; i < rows.rows(); ++i) {
    const double dt = rows.session[i] == rows.session[i - 1] ? rows.time[i] - rows.time[i - 1] : 0.0;
    const double before = rows.direction[i] * rows.speed[i - 1], now = rows.direction[i] * rows.speed[i];
    if (now <= 0.0) continue;
    travel[i] = before >= 0.0 ? 0.5 * dt * (before + now) : 0.5 * dt * now * now / (now - before);
  }
  return travel;
}

/// How long the current rest lasts, or, in motion, the last one lasted [s].
ArrayXd restOf(const ActuatorRows& rows, double dead_band) {
  ArrayXd rest = ArrayXd::Zero(rows.rows());
  for (Index i = 1; i < rows.rows(); ++i) {
    if (rows.session[i] != rows.session[i - 1]) continue;
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
void leaveOutUncertainReversals(const ActuatorRows& rows, double dead_band, std::vector<bool>& keep) {
  constexpr double kUncertain = 0.3;  // [s]
  const auto most = static_cast<Index>(std::ceil(kUncertain / rows.step));
  double last_side = 0.0;
  Index last = -1;
  for (Index i = 0; i < rows.rows(); ++i) {
    if (std::abs(rows.speed[i]) <= dead_band) continue;
    const double side = rows.speed[i] > 0.0 ? 1.0 : -1.0;
    if (last_side != 0.0 && side != last_side && rows.direction[i] == side) {
      for (Index k = std::max(last + 1, i - most); k < i; ++k) keep[k] = false;
    }
    last_side = side;
    last = i;
  }
}

/// Time within sessions, cut into blocks.
double blockSeconds(const std::vector<double>& time, const std::vector<int>& session) {
  double seconds = 0.0;
  for (const Block& b : splitRows(session, session.size())) seconds += time[b.end - 1] - time[b.begin];
  const double shortest = std::max(seconds / kFewestBlocks, kFewestRows * seconds / static_cast<double>(time.size()));
  return std::clamp(seconds / kBlocks, std::min(kShortestBlock, shortest), kLongestBlock);
}

double medianStep(const ActuatorRows& rows) {
  std::vector<double> steps;
  for (Index i = 1; i < rows.rows(); ++i) {
    if (rows.session[i] == rows.session[i - 1]) steps.push_back(rows.time[i] - rows.time[i - 1]);
  }
  return steps.empty() ? 1.0 : upperMedian(std::move(steps));
}

/// A channel that the residual may depend on.
void addContext(PreparedLog& log, const std::string& name, const ArrayXd& values) {
  const double mean = values.mean(), sd = std::sqrt((values - mean).square().mean());
  if (!(sd > 1e-9 * (1.0 + std::abs(mean)))) return;
  log.context.push_back({name, values});
  log.data.rows.context.push_back((values - mean) / sd);
}

double correlation(const ArrayXd& a, const ArrayXd& b) {
  const ArrayXd x = a - a.mean(), y = b - b.mean();
  return (x * y).sum() / std::max(std::sqrt(x.square().sum() * y.square().sum()), 1e-300);
}

/// Numeric columns that no quantity of the model came from. A command or an estimate that follows the effort is no
/// cause: it says what was measured once more. \param own  further stems that the model reads.
void addContext(const CsvTable& table, PreparedLog& log, const std::set<std::string>& own = {}) {
  constexpr double kCopy = 0.9;  // correlation
  static const std::set<std::string> kKnown = {"time",           "motor_current",  "motor_voltage", "motor_torque",
                                               "motor_force",    "motor_velocity", "velocity",      "joint_velocity",
                                               "motor_position", "position",       "session",       "external_torque",
                                               "external_force", "current",        "voltage",       "load_torque",
                                               "pressure",       "contraction",    "force"};
  for (const std::string& column : table.columns()) {
    const std::string stem = splitUnit(column).stem;
    const bool known = kKnown.contains(column) || kKnown.contains(stem) || own.contains(stem);
    if (known || !table.isNumeric(column)) continue;
    ArrayXd values;
    try {
      values = toArray(table.quantity(column, ""));
    } catch (const DataError&) {
      continue;  // empty cells in a column nobody asked for
    }
    if (const double r = correlation(values, log.data.rows.effort); std::abs(r) > kCopy) {
      log.warnings.push_back(
          fmt::format("{} follows {} (correlation {:.2f}): not looked at as a cause", column, log.effort_column, r));
      continue;
    }
    addContext(log, column, values);
  }
}

/// Before the first motion the direction is unknown: those rows do not count, but every number has to be one.
void fillDirection(ActuatorRows& rows) {
  const auto first = std::find_if(rows.direction.begin(), rows.direction.end(), [](double d) { return d != 0.0; });
  std::fill(rows.direction.begin(), first, first != rows.direction.end() ? *first : 1.0);
}

/// What all logs have; channels without meaning for this kind are 0.
PreparedLog prepared(ActuatorKind kind, const std::string& file, const std::vector<double>& time,
                     const std::vector<int>& session, const std::vector<std::string>& session_names) {
  PreparedLog log;
  log.kind = kind;
  log.file = file;
  log.session_names = session_names;
  log.blocks = splitBlocks(time, session, blockSeconds(time, session));
  log.data.keep.assign(time.size(), true);
  ActuatorRows& rows = log.data.rows;
  rows.time = toArray(time);
  rows.session = session;
  rows.step = medianStep(rows);
  rows.speed = rows.load = rows.acceleration = rows.travel = rows.rest = ArrayXd::Zero(rows.time.size());
  return log;
}

void setDirection(const std::vector<double>& motion, PreparedLog& log) {
  const MotionSign sign = holdSign(motion);
  ActuatorRows& rows = log.data.rows;
  rows.direction.resize(motion.size());
  std::ranges::copy(sign.direction, rows.direction.begin());
  fillDirection(rows);
  log.dead_band = sign.dead_band;
  rows.top_speed = rows.speed.abs().maxCoeff();
}

/// What a muscle's friction opposes: the change of its contraction or, in sessions at one length, of its pressure.
std::vector<double> changesOf(const PamLog& log, const ActuatorRows& rows) {
  constexpr double kFixedLength = 2e-3;  // spread of a contraction that is held
  std::vector<double> changes(log.rows(), 0.0);
  for (const Block& b : splitRows(log.session, log.rows())) {
    const Index begin = b.begin, n = b.size();
    const auto spread = [&](const ArrayXd& values) {
      return values.segment(begin, n).maxCoeff() - values.segment(begin, n).minCoeff();
    };
    const ArrayXd& moved = spread(rows.contraction) > kFixedLength ? rows.contraction : rows.pressure;
    const double scale = std::max(spread(moved), 1e-300);
    ArrayXd slope = ArrayXd::Zero(n);
    if (log.time.empty()) {  // levels, one after the other
      slope.tail(n - 1) = moved.segment(begin, n).tail(n - 1) - moved.segment(begin, n).head(n - 1);
    } else if (n >= 4) {
      const std::span<const double> time(log.time.data() + b.begin, b.size());
      const std::span<const double> values(moved.data() + begin, b.size());
      slope = toArray(differentiate(time, smooth(time, values, FrictionDataOptions::kDefaultBandwidth / rows.step)));
    }
    ArrayXd::Map(changes.data() + begin, n) = slope / scale;
  }
  return changes;
}

/// Rows in and beside a jump: where a rate of change is far above its usual size, sampling and smoothing have blurred
/// it.
void leaveOutJumps(const ArrayXd& rate, std::vector<bool>& keep) {
  constexpr double kJump = 6.0;  // of the median size
  constexpr Index kBeside = 4;
  std::vector<double> sizes(rate.begin(), rate.end());
  for (double& size : sizes) size = std::abs(size);
  const double most = kJump * upperMedian(std::move(sizes));
  for (Index i = 0; i < rate.size() && most > 0.0; ++i) {
    if (std::abs(rate[i]) <= most) continue;
    for (Index k = std::max<Index>(0, i - kBeside); k < std::min(rate.size(), i + kBeside + 1); ++k) keep[k] = false;
  }
}

/// Single wrong samples, looked for session by session, and sensors at their limit. A wrong deflection is replaced: a
/// spring that remembers would carry it on.
void leaveOutBadSamples(SpringLog& spring, PreparedLog& log) {
  ChannelSpikes deflection{quantityName("deflection", spring.deflectionUnit()), {}}, force{log.effort_column, {}};
  for (const Block& b : splitRows(spring.session, spring.rows())) {
    const std::span<const double> time(spring.time.data() + b.begin, b.size());
    const std::span<double> moved(spring.deflection.data() + b.begin, b.size());
    for (const std::size_t i : repairSpikes(time, moved)) deflection.rows.push_back(b.begin + i);
    const std::span<const double> pulled(spring.force.data() + b.begin, b.size());
    for (const std::size_t i : findSpikes(time, pulled)) force.rows.push_back(b.begin + i);
  }
  const ChannelSpikes ends[] = {{deflection.channel, findClipped(spring.deflection, spring.force, spring.session)},
                                {force.channel, findClipped(spring.force, spring.deflection, spring.session)}};
  for (const ChannelSpikes& channel : {deflection, force}) {
    if (!channel.rows.empty()) log.spikes.push_back(channel);
  }
  for (const ChannelSpikes& channel : ends) {
    if (!channel.rows.empty()) log.clipped.push_back(channel);
  }
  for (const std::vector<ChannelSpikes>* list : {&log.spikes, &log.clipped}) {
    for (const ChannelSpikes& channel : *list) {
      for (const std::size_t i : channel.rows) log.data.keep[i] = false;
    }
  }
}

}  // namespace

PreparedLog prepareActuatorData(const CsvTable& table, const Bench& bench, const ActuatorLogOptions& log_options,
                                FrictionDataOptions options) {
  options.all_rows = true;
  const ActuatorLog drive = readActuatorLog(table, log_options);
  options.block_seconds = blockSeconds(drive.time, drive.session);
  const FrictionData friction = prepareFrictionData(drive, bench, options);
  PreparedLog log;
  if (friction.fits_angle) {
    throw ConfigError(friction.file + ": found angle_offset_rad: fit, expected a number here: fit-friction finds it");
  }
  log.file = friction.file;
  log.effort_column = quantityName(friction.effort_name, friction.effort_unit);
  log.session_names = friction.session_names;
  log.dead_band = friction.dead_band;
  log.warnings = friction.warnings;
  log.spikes = friction.spikes;
  log.blocks = friction.blocks;
  ActuatorData& data = log.data;
  data.keep = friction.keep;
  data.load_unit = friction.load_unit;
  data.effort_unit = friction.effort_unit;
  data.velocity_unit = friction.velocity_unit;
  data.rig = friction.load_per;
  for (std::size_t k = 0; k < friction.rig_names.size(); ++k) {
    data.rig_parameters.push_back({friction.rig_names[k], friction.rig_units[k]});
  }
  ActuatorRows& rows = data.rows;
  rows.time = friction.time;
  rows.effort = friction.effort;
  rows.speed = friction.velocity;
  rows.load = friction.load;
  rows.session = friction.session;
  rows.direction = friction.direction;
  fillDirection(rows);
  rows.step = medianStep(rows);
  leaveOutUncertainReversals(rows, log.dead_band, data.keep);
  rows.top_speed = rows.speed.abs().maxCoeff();
  rows.top_load = rows.load.abs().maxCoeff();
  rows.acceleration =
      slopeOf(rows, rows.speed, options.bandwidth.value_or(FrictionDataOptions::kDefaultBandwidth / rows.step));
  rows.travel = travelOf(rows);
  rows.rest = restOf(rows, log.dead_band);
  rows.joint_angle = optional(table, "joint_position", "rad");
  rows.motor_angle = optional(table, "motor_position", "rad");
  if (rows.joint_angle.size() == 0 && !drive.position.empty()) {
    rows.joint_angle = toArray(drive.position) / (log_options.ratio > 0.0 ? log_options.ratio : 1.0);
  }
  rows.temperature = optional(table, "temperature", "degC");
  addContext(table, log);
  addContext(log, "motor_velocity", rows.speed);
  addContext(log, "external_torque", rows.load);
  addContext(log, "time", rows.time);
  return log;
}

PreparedLog prepareGearboxData(const CsvTable& table, const Bench& bench, const ActuatorLogOptions& log_options,
                               const FrictionDataOptions& options) {
  PreparedLog log = prepareActuatorData(table, bench, log_options, options);
  log.kind = ActuatorKind::kGearbox;
  leaveOutJumps(log.data.rows.acceleration, log.data.keep);
  return log;
}

PreparedLog prepareMotorData(const CsvTable& table) {
  const MotorLog motor = readMotorLog(table);
  for (const auto& [name, channel] :
       {std::pair("voltage_V", &motor.voltage), {"current_A", &motor.current}, {"velocity_rad_s", &motor.velocity}}) {
    if (channel->empty())
      throw DataError(fmt::format("{}:1: found no {}, expected it to diagnose a winding", motor.file, name));
  }
  PreparedLog log = prepared(ActuatorKind::kMotor, motor.file, motor.time, motor.session, motor.session_names);
  log.effort_column = "voltage_V";
  log.data.effort_unit = log.data.load_unit = "V";
  ActuatorRows& rows = log.data.rows;
  rows.effort = toArray(motor.voltage);
  rows.current = toArray(motor.current);
  rows.speed = toArray(motor.velocity);
  setDirection(motor.velocity, log);
  rows.current_rate = slopeOf(rows, rows.current, FrictionDataOptions::kDefaultBandwidth / rows.step);
  rows.temperature = optional(table, "temperature", "degC");
  leaveOutJumps(rows.current_rate, log.data.keep);
  addContext(table, log);
  addContext(log, "current", rows.current);
  addContext(log, "velocity", rows.speed);
  addContext(log, "time", rows.time);
  return log;
}

PreparedLog preparePamData(const CsvTable& table) {
  const PamLog muscle = readPamLog(table);
  std::vector<double> time = muscle.time;
  if (time.empty()) {  // rows in their order
    time.resize(muscle.rows());
    std::iota(time.begin(), time.end(), 0.0);
  }
  PreparedLog log = prepared(ActuatorKind::kPam, muscle.file, time, muscle.session, muscle.session_names);
  log.effort_column = "force_N";
  log.data.effort_unit = log.data.load_unit = "N";
  ActuatorRows& rows = log.data.rows;
  rows.effort = toArray(muscle.force);
  rows.pressure = toArray(muscle.pressure);
  rows.contraction = toArray(muscle.contraction);
  setDirection(changesOf(muscle, rows), log);
  rows.temperature = optional(table, "temperature", "degC");
  addContext(table, log);
  addContext(log, "pressure", rows.pressure);
  addContext(log, "contraction", rows.contraction);
  addContext(log, "time", rows.time);
  return log;
}

PreparedLog prepareSpringData(const CsvTable& table) {
  SpringLog spring = readSpringLog(table);
  PreparedLog log = prepared(ActuatorKind::kSpring, spring.file, spring.time, spring.session, spring.session_names);
  log.effort_column = quantityName(spring.forceName(), spring.forceUnit());
  log.data.effort_unit = log.data.load_unit = spring.forceUnit();
  log.data.velocity_unit = spring.angular ? "rad_s" : "m_s";
  leaveOutBadSamples(spring, log);
  ActuatorRows& rows = log.data.rows;
  rows.timed = spring.has_time;
  rows.effort = toArray(spring.force);
  rows.deflection = toArray(spring.deflection);
  if (spring.has_time) {
    rows.speed = slopeOf(rows, rows.deflection, FrictionDataOptions::kDefaultBandwidth / rows.step);
    setDirection({rows.speed.begin(), rows.speed.end()}, log);
  } else {
    ArrayXd change = ArrayXd::Zero(rows.rows());
    change.tail(rows.rows() - 1) = rows.deflection.tail(rows.rows() - 1) - rows.deflection.head(rows.rows() - 1);
    setDirection({change.begin(), change.end()}, log);
  }
  rows.temperature = optional(table, "temperature", "degC");
  addContext(table, log, {"deflection", "length", "torque"});
  addContext(log, "deflection", rows.deflection);
  if (spring.has_time) {
    addContext(log, "deflection_rate", rows.speed);
    addContext(log, "time", rows.time);
  }
  return log;
}

PreparedLog prepareTransmissionData(const PreparedLog& drive) {
  PreparedLog log = drive;
  log.kind = ActuatorKind::kTransmission;
  log.effort_column = "joint_position_rad";
  log.data.effort_unit = "rad";
  log.data.rig.resize(log.data.rows.rows(), 0);
  log.data.rig_parameters.clear();
  log.data.rows.effort = log.data.rows.joint_angle;
  log.context.clear();
  log.data.rows.context.clear();
  return log;
}

PreparedLog prepareLog(const CsvTable& table, const Bench& bench, ActuatorKind kind, FrictionDataOptions options) {
  if (kind == ActuatorKind::kMotor) return prepareMotorData(table);
  if (kind == ActuatorKind::kPam) return preparePamData(table);
  if (kind == ActuatorKind::kSpring) return prepareSpringData(table);
  const ActuatorLogOptions log_options{.ratio = bench.ratio.value_or(0.0)};
  options.bandwidth = bench.bandwidth;
  if (kind == ActuatorKind::kGearbox) return prepareGearboxData(table, bench, log_options, options);
  return prepareActuatorData(table, bench, log_options, options);
}

}  // namespace simgap
