#include "prepared_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <span>

#include "simgap/core/statistics.h"
#include "simgap/core/units.h"
#include "simgap/measure/logs/motion.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr double kBlocks = 80.0;                              // that a log is cut into, if they are long enough
constexpr double kShortestBlock = 4.0, kLongestBlock = 20.0;  // [s]
constexpr double kFewestBlocks = 40.0;                        // of a log so short that blocks have to be shorter
constexpr double kFewestRowsOfBlock = 50.0;                   // per block

}  // namespace

ArrayXd toArray(const std::vector<double>& values) { return Eigen::Map<const ArrayXd>(values.data(), values.size()); }

PreparedLog prepared(ActuatorKind kind, const std::string& file, const std::vector<double>& time,
                     const std::vector<int>& session, const std::vector<std::string>& session_names) {
  PreparedLog log;
  log.kind = kind;
  log.file = file;
  log.session_names = session_names;
  log.blocks = splitBlocks(time, session, blockSecondsOf(time, session));
  log.data.keep.assign(time.size(), true);
  ActuatorRows& rows = log.data.rows;
  rows.time = toArray(time);
  rows.session = session;
  rows.step = medianStep(rows);
  rows.elapsed = elapsedOf(rows.time, rows.session);
  rows.speed = rows.load = rows.acceleration = rows.travel = rows.rest = ArrayXd::Zero(rows.time.size());
  return log;
}

double blockSecondsOf(const std::vector<double>& time, const std::vector<int>& session) {
  double seconds = 0.0;
  for (const Block& b : splitRows(session, session.size())) seconds += time[b.end - 1] - time[b.begin];
  const double shortest =
      std::max(seconds / kFewestBlocks, kFewestRowsOfBlock * seconds / static_cast<double>(time.size()));
  return std::clamp(seconds / kBlocks, std::min(kShortestBlock, shortest), kLongestBlock);
}

double medianStep(const ActuatorRows& rows) {
  std::vector<double> steps;
  for (Index i = 1; i < rows.rows(); ++i) {
    if (rows.session[i] == rows.session[i - 1]) steps.push_back(rows.time[i] - rows.time[i - 1]);
  }
  return steps.empty() ? 1.0 : upperMedian(std::move(steps));
}

ArrayXd optional(const CsvTable& table, const char* stem, const char* unit, PreparedLog& log) {
  if (!table.offersQuantity(stem, unit)) return {};
  const std::string& column = table.columns()[matchQuantity(table.columns(), stem, unit)[0].index];
  const std::size_t bad = table.badRows(column).size();
  if (bad == 0) return toArray(table.quantity(stem, unit));
  std::string warning =
      fmt::format("{} has no number in {} of {} rows: it was not looked at", column, bad, table.rows());
  if (std::ranges::find(log.warnings, warning) == log.warnings.end()) log.warnings.push_back(std::move(warning));
  return {};
}

void addContext(PreparedLog& log, const std::string& name, const ArrayXd& values) {
  const double mean = values.mean(), sd = std::sqrt((values - mean).square().mean());
  if (!(sd > 1e-9 * (1.0 + std::abs(mean)))) return;
  log.context.push_back({name, values});
  log.data.rows.context.push_back((values - mean) / sd);
}

void addContext(const CsvTable& table, PreparedLog& log, const std::set<std::string>& own) {
  constexpr double kCopy = 0.9;  // correlation
  static const std::set<std::string> kMayCause = {"joint_position", "temperature", "deflection", "length", "torque"};
  for (const std::string& column : table.columns()) {
    const std::string stem = splitUnit(column).stem;
    const bool may_cause = (!isLogChannel(column) || kMayCause.contains(stem)) && !own.contains(stem);
    if (!may_cause || !table.isNumeric(column)) continue;
    const ArrayXd values = optional(table, column.c_str(), "", log);
    if (values.size() == 0) continue;
    if (const double r = correlation(spanOf(values), spanOf(log.data.rows.effort)); std::abs(r) > kCopy) {
      log.warnings.push_back(
          fmt::format("{} follows {} (correlation {:.2f}): not looked at as a cause", column, log.effort_column, r));
      continue;
    }
    addContext(log, column, values);
  }
}

void addOptional(const CsvTable& table, PreparedLog& log,
                 std::initializer_list<std::pair<const char*, const ArrayXd*>> own) {
  log.data.rows.temperature = optional(table, "temperature", "degC", log);
  addContext(table, log);
  for (const auto& [name, values] : own) addContext(log, name, *values);
  addContext(log, "time", log.data.rows.elapsed);
}

ArrayXd slopeOf(const ActuatorRows& rows, const ArrayXd& values, double bandwidth) {
  ArrayXd slopes = ArrayXd::Zero(rows.rows());
  for (const Block& b : splitRuns(spanOf(rows.time), rows.session)) {
    if (b.size() < 4) continue;
    const std::span<const double> time(rows.time.data() + b.begin, b.size());
    const std::span<const double> part(values.data() + b.begin, b.size());
    const std::vector<double> slope = differentiate(time, smooth(time, part, bandwidth));
    slopes.segment(b.begin, b.size()) = toArray(slope);
  }
  return slopes;
}

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

void setDirection(const std::vector<double>& motion, PreparedLog& log) {
  const MotionSign sign = holdSign(motion);
  ActuatorRows& rows = log.data.rows;
  rows.direction.resize(motion.size());
  std::ranges::copy(sign.direction, rows.direction.begin());
  fillDirection(rows);
  log.dead_band = sign.dead_band;
  rows.top_speed = rows.speed.abs().maxCoeff();
}

void fillDirection(ActuatorRows& rows) {
  const auto first = std::find_if(rows.direction.begin(), rows.direction.end(), [](double d) { return d != 0.0; });
  std::fill(rows.direction.begin(), first, first != rows.direction.end() ? *first : 1.0);
}

void leaveOutRows(const std::vector<ChannelSpikes>& channels, std::vector<bool>& keep) {
  for (const ChannelSpikes& channel : channels) {
    for (const std::size_t i : channel.rows) keep[i] = false;
  }
}

void leaveOutJumps(const ArrayXd& rate, std::vector<bool>& keep) {
  constexpr double kJump = 6.0;  // of the median size
  constexpr Index kBeside = 4;
  std::vector<double> sizes;  // of motion: in a log that mostly rests the median of all would be that of rest
  for (Index i = 0; i < rate.size(); ++i) {
    if (keep[static_cast<std::size_t>(i)]) sizes.push_back(std::abs(rate[i]));
  }
  if (sizes.empty()) return;
  const double most = kJump * upperMedian(std::move(sizes));
  for (Index i = 0; i < rate.size() && most > 0.0; ++i) {
    if (std::abs(rate[i]) <= most) continue;
    for (Index k = std::max<Index>(0, i - kBeside); k < std::min(rate.size(), i + kBeside + 1); ++k) keep[k] = false;
  }
}

}  // namespace simgap
