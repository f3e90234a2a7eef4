#include "log_faults.h"

#include <fmt/format.h>

#include <Eigen/QR>
#include <algorithm>
#include <cmath>

#include "simgap/core/statistics.h"
#include "simgap/measure/logs/motion.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr double kFewSpikes = 0.01;  // share of the rows that may be taken out without a verdict
constexpr double kSpike = 8.0;       // in robust standard deviations
constexpr double kUndecided = 4.0;   // likewise
constexpr double kOther = 0.3;       // of the residual: what the other direction may leave to be the right one

struct NamedChannel {
  std::string name;
  const ArrayXd& values;
};

DataFault faultOf(const std::string& channel, const std::string& sentence, Index first, Index last, std::size_t rows) {
  return {channel, sentence, static_cast<std::size_t>(first + 1), static_cast<std::size_t>(last + 1), rows, false};
}

/// Rows at the very end of the range, several in a row: a converter or an amplifier that cannot go further.
void findClipping(const NamedChannel& channel, std::vector<DataFault>& faults) {
  for (const double limit : {channel.values.maxCoeff(), channel.values.minCoeff()}) {
    std::size_t rows = 0, runs = 0;
    Index first = -1, last = -1;
    for (Index i = 0, end = 0; i < channel.values.size(); i = std::max(end, i + 1)) {
      end = i;
      while (end < channel.values.size() && channel.values[end] == limit) ++end;
      if (end - i < 4) continue;
      if (first < 0) first = i;
      last = end - 1;
      rows += static_cast<std::size_t>(end - i);
      ++runs;
    }
    if (limit == 0.0 || runs < 2 || static_cast<double>(rows) < 1e-3 * static_cast<double>(channel.values.size()))
      continue;
    faults.push_back(
        faultOf(channel.name,
                fmt::format("{} sits at its limit {:.4g} in {} rows ({} times for at least 4 rows in a row): "
                            "saturated; leave them out, or record with a wider range",
                            channel.name, limit, rows, runs),
                first, last, rows));
  }
}

/// A channel that repeats one value for a second and longer while the drive moves, though it is noisy otherwise.
void findStuck(const NamedChannel& channel, const PreparedLog& log, std::vector<DataFault>& faults) {
  const ActuatorRows& rows = log.data.rows;
  const Index n = channel.values.size();
  Index repeats = 0;
  for (Index i = 1; i < n; ++i) repeats += channel.values[i] == channel.values[i - 1] ? 1 : 0;
  if (static_cast<double>(repeats) > 0.3 * static_cast<double>(n)) return;  // coarse steps: repeats are normal
  const auto least = static_cast<Index>(std::max(10.0, 0.5 / rows.step));
  std::size_t stuck = 0;
  Index first = -1, last = -1;
  for (Index i = 0, end = 0; i < n; i = end) {
    end = i + 1;
    while (end < n && channel.values[end] == channel.values[i]) ++end;
    if (end - i < least || !(rows.speed.segment(i, end - i).abs().mean() > 2.0 * log.dead_band)) continue;
    if (first < 0) first = i;
    last = end - 1;
    stuck += static_cast<std::size_t>(end - i);
  }
  if (stuck == 0) return;
  faults.push_back(
      faultOf(channel.name,
              fmt::format("{} is stuck (one value for {:.1f} s and longer while the drive moves) in {} rows: "
                          "leave them out, or mend the sensor",
                          channel.name, static_cast<double>(least) * rows.step, stuck),
              first, last, stuck));
}

/// Exact zeros among values that are far from it.
void findDropouts(const NamedChannel& channel, std::vector<DataFault>& faults) {
  const Index n = channel.values.size();
  const double noise = noiseLevel(std::span<const double>(channel.values.data(), static_cast<std::size_t>(n)));
  std::size_t rows = 0;
  Index first = -1, last = -1;
  for (Index i = 1; i + 1 < n; ++i) {
    if (channel.values[i] != 0.0) continue;
    Index end = i;
    while (end + 1 < n && channel.values[end] == 0.0) ++end;
    const double before = channel.values[i - 1], after = channel.values[end];
    const double drop = std::min(std::abs(before), std::abs(after));
    // A short rest between two moves is no dropout: there the values beside it change as fast.
    const double earlier = channel.values[std::max<Index>(i - 2, 0)], later = channel.values[std::min(end + 1, n - 1)];
    const double beside = std::max(std::abs(before - earlier), std::abs(later - after));
    if (end - i <= 5 && before * after > 0.0 && drop > std::max(12.0 * noise, 3.0 * beside)) {
      if (first < 0) first = i;
      last = end - 1;
      rows += static_cast<std::size_t>(end - i);
    }
    i = end;
  }
  if (rows < 3) return;
  faults.push_back(faultOf(
      channel.name,
      fmt::format("{} drops to exactly 0 and back in {} rows: lost samples; leave them out", channel.name, rows), first,
      last, rows));
}

/// Signs that no drive can have: load that helps to draw current, friction that gives energy.
void findMirrored(const PreparedLog& log, std::vector<DataFault>& faults) {
  const ActuatorRows& rows = log.data.rows;
  const Index n = rows.rows();
  Eigen::MatrixXd x(n, 5);
  x << rows.load, rows.load.abs() * rows.direction, rows.direction, rows.speed, Eigen::ArrayXd::Ones(n);
  for (Index i = 0; i < n; ++i) {
    if (!log.data.keep[static_cast<std::size_t>(i)]) x.row(i).setZero();
  }
  const Eigen::VectorXd scale = x.colwise().norm().transpose();
  const Eigen::VectorXd c = x.colPivHouseholderQr().solve(rows.effort.matrix()).cwiseProduct(scale);
  const double size = (rows.effort - rows.effort.mean()).matrix().norm();
  const double friction = c[1] + c[2] + c[3];
  if (rows.top_load > 0.0 && c[0] < -0.2 * size) {
    faults.push_back({"external_torque",
                      fmt::format("{} falls where the load grows: one of {} and external_torque has the wrong sign",
                                  log.effort_column, log.effort_column)});
  } else if (friction < -0.1 * size) {
    faults.push_back(
        {"motor_velocity",
         fmt::format("friction would drive the motor: {} and motor_velocity have opposite signs", log.effort_column)});
  }
  if (rows.joint_angle.size() == 0) return;
  double with = 0.0, speed = 0.0, angle = 0.0;
  for (Index i = 1; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (rows.session[k] != rows.session[k - 1]) continue;
    const double rate =
        (rows.joint_angle[i] - rows.joint_angle[i - 1]) / std::max(rows.time[i] - rows.time[i - 1], 1e-9);
    with += rate * rows.speed[i];
    speed += rows.speed[i] * rows.speed[i];
    angle += rate * rate;
  }
  if (with < -0.3 * std::sqrt(speed * angle)) {
    faults.push_back({"joint_position",
                      "the joint angle falls where the motor turns forwards: joint_position or "
                      "motor_velocity has the wrong sign"});
  }
}

/// Of the rows that count.
double deviationOf(const Eigen::VectorXd& residual) {
  std::vector<double> values;
  std::ranges::copy_if(residual, std::back_inserter(values), [](double r) { return r != 0.0; });
  return values.empty() ? 0.0 : robustDeviation(std::move(values));
}

}  // namespace

std::vector<DataFault> findFaults(const PreparedLog& log) {
  const ActuatorRows& rows = log.data.rows;
  if (log.kind == ActuatorKind::kMotor || log.kind == ActuatorKind::kPam) {
    // Voltages and pressures are set to levels, limits included: only lost samples can be told.
    const bool motor = log.kind == ActuatorKind::kMotor;
    std::vector<DataFault> faults;
    findDropouts({motor ? "current_A" : log.effort_column, motor ? rows.current : rows.effort}, faults);
    return faults;
  }
  std::vector<NamedChannel> channels = {{log.effort_column, rows.effort}, {"motor_velocity", rows.speed}};
  if (rows.top_load > 0.0) channels.push_back({"external_torque", rows.load});
  std::vector<DataFault> faults;
  for (const NamedChannel& channel : channels) {
    if (channel.name != "external_torque") findClipping(channel, faults);
    findStuck(channel, log, faults);
    findDropouts(channel, faults);
  }
  findMirrored(log, faults);
  return faults;
}

std::size_t takeOutUndecided(PreparedLog& log, const Eigen::VectorXd& residual, const Eigen::VectorXd& flipped) {
  const double limit = kUndecided * deviationOf(residual);
  std::size_t rows = 0;
  for (Index i = 0; i < residual.size(); ++i) {
    const bool between = residual[i] * flipped[i] < 0.0;
    const bool other = std::abs(flipped[i]) < std::min(limit, kOther * std::abs(residual[i]));
    if (!(between || other) || std::abs(residual[i]) < limit || std::abs(log.data.rows.speed[i]) > log.dead_band)
      continue;
    log.data.keep[static_cast<std::size_t>(i)] = false;
    ++rows;
  }
  return rows;
}

std::vector<DataFault> takeOutSpikes(PreparedLog& log, const Eigen::VectorXd& residual) {
  const ActuatorRows& rows = log.data.rows;
  const double limit = kSpike * deviationOf(residual);
  std::vector<Index> spikes;
  for (Index i = 2; i + 2 < residual.size(); ++i) {
    if (std::abs(residual[i]) <= limit || std::abs(rows.speed[i]) < 3.0 * log.dead_band) continue;
    // A spike stands alone; a misfit has neighbours.
    const double around = std::max({std::abs(residual[i - 2]), std::abs(residual[i + 2])});
    const bool reversal = rows.direction[i - 2] != rows.direction[i + 2];
    if (around < 0.3 * std::abs(residual[i]) && !reversal) spikes.push_back(i);
  }
  if (spikes.empty()) return {};
  DataFault fault =
      faultOf(log.effort_column,
              fmt::format("{} rows stand alone, more than {:.0f} robust standard deviations off the model: "
                          "outliers",
                          spikes.size(), kSpike),
              spikes.front(), spikes.back(), spikes.size());
  fault.corrected =
      static_cast<double>(spikes.size()) <= kFewSpikes * static_cast<double>((residual.array() != 0.0).count());
  if (fault.corrected) {
    fault.sentence += "; they were left out";
    for (const Index i : spikes) log.data.keep[static_cast<std::size_t>(i)] = false;
  }
  return {fault};
}

}  // namespace simgap
