#include "log_faults.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>

#include "simgap/core/decompositions.h"
#include "simgap/core/statistics.h"
#include "simgap/fit/actuators/winding_signs.h"
#include "simgap/measure/logs/log_kind.h"
#include "simgap/measure/logs/resolution.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

constexpr double kMostLeftOut = 0.4;  // of the rows: with more of them gone the rest tells another story
constexpr double kSpike = 8.0;        // in robust standard deviations
constexpr double kUndecided = 4.0;    // likewise
constexpr double kMirrored = 0.7;     // correlation of effort and load beyond which signs are opposite
constexpr double kOther = 0.3;        // of the residual: what the other direction may leave to be the right one

struct NamedChannel {
  std::string name;
  const ArrayXd& values;
};

/// Rows that cannot be believed are left out, and said; only where little else is left they are a reason to stop.
void leaveOut(const std::string& channel, const std::string& sentence, const std::vector<Index>& bad, PreparedLog& log,
              std::vector<DataFault>& faults) {
  DataFault fault{
      channel,    sentence, static_cast<std::size_t>(bad.front() + 1), static_cast<std::size_t>(bad.back() + 1),
      bad.size(), false};
  fault.corrected = static_cast<double>(bad.size()) <= kMostLeftOut * static_cast<double>(log.data.rows.rows());
  if (fault.corrected) {
    fault.sentence += "; they were left out";
    const bool of_effort = channel == log.effort_column;
    if (of_effort) log.data.effort_lost.resize(log.data.keep.size(), false);
    for (const Index i : bad) {
      log.data.keep[i] = false;
      if (of_effort) log.data.effort_lost[i] = true;
    }
  }
  faults.push_back(std::move(fault));
}

constexpr std::size_t kTogether = 4;  // rows in a row that stand at a limit

/// The end of a channel's range: its largest value, or the largest that stands several rows in a row where a few, of
/// spikes, are beyond it. \param way  1; -1: its smallest
double endOfRange(const ArrayXd& values, double way) {
  constexpr double kSpikes = 1e-3;  // of the rows
  double end = -std::numeric_limits<double>::infinity();
  for (Index i = 0, next = 0; i < values.size(); i = next) {
    next = i + 1;
    while (next < values.size() && values[next] == values[i]) ++next;
    if (next - i >= static_cast<Index>(kTogether)) end = std::max(end, way * values[i]);
  }
  const auto beyond = static_cast<double>((way * values > end).count());
  return way * (beyond <= kSpikes * static_cast<double>(values.size()) ? end : (way * values).maxCoeff());
}

/// Rows at the very end of a range that is reached several rows in a row, and more than once: a converter or an
/// amplifier that cannot go further, unless it comes there by single counts. The rows beside them go with them: so near
/// to a limit only those are left that noise has made small. \returns those ends.
std::vector<double> findClipping(const NamedChannel& channel, PreparedLog& log, std::vector<DataFault>& faults) {
  constexpr double kBeside = 0.1;  // [s]
  const auto beside = static_cast<Index>(std::ceil(kBeside / log.data.rows.step));
  std::vector<double> limits;
  for (const double limit : {endOfRange(channel.values, 1.0), endOfRange(channel.values, -1.0)}) {
    std::size_t runs = 0;
    std::vector<Index> rows;
    for (const Block& run : runsAt(spanOf(channel.values), limit)) {
      for (std::size_t i = run.begin; i < run.end; ++i) rows.push_back(static_cast<Index>(i));
      if (run.size() >= kTogether) ++runs;
    }
    if (limit == 0.0 || runs < 2 ||
        static_cast<double>(rows.size()) < 1e-3 * static_cast<double>(channel.values.size()) ||
        comesByCounts(spanOf(channel.values), limit, kTogether))
      continue;
    const std::string sentence =
        fmt::format("{} sits at its limit {:.4g} in {} rows ({} times in 4 and more together): saturated", channel.name,
                    limit, rows.size(), runs);
    std::vector<Index> near;
    for (const Index i : rows) {
      const Index first = std::max(i - beside, near.empty() ? 0 : near.back() + 1);
      for (Index k = first; k < std::min(i + beside + 1, channel.values.size()); ++k) near.push_back(k);
    }
    leaveOut(channel.name, sentence, near, log, faults);
    limits.push_back(limit);
  }
  return limits;
}

/// Whether values between the ends of a channel are few or often come twice: coarse steps, or what is set and not
/// measured.
bool isCoarse(const NamedChannel& channel) {
  constexpr double kFewest = 0.5, kOften = 0.3;  // of the rows
  const Index n = channel.values.size();
  const auto inside = channel.values > channel.values.minCoeff() && channel.values < channel.values.maxCoeff();
  const auto again = channel.values.tail(n - 1) == channel.values.head(n - 1);
  const auto rows = static_cast<double>(inside.count());
  return rows < kFewest * static_cast<double>(n) ||
         static_cast<double>((again && inside.tail(n - 1)).count()) > kOften * rows;
}

/// A channel that repeats one value for a second and longer while the drive moves, though it is noisy otherwise.
/// \param limits  where it is saturated instead
void findStuck(const NamedChannel& channel, const std::vector<double>& limits, PreparedLog& log,
               std::vector<DataFault>& faults) {
  const ActuatorRows& rows = log.data.rows;
  if (isCoarse(channel)) return;
  const Index n = channel.values.size();
  const auto least = static_cast<Index>(std::max(10.0, 0.5 / rows.step));
  std::vector<Index> stuck;
  for (Index i = 0, end = 0; i < n; i = end) {
    end = i + 1;
    while (end < n && channel.values[end] == channel.values[i]) ++end;
    if (std::ranges::find(limits, channel.values[i]) != limits.end()) continue;
    if (end - i < least || !(rows.speed.segment(i, end - i).abs().mean() > 2.0 * log.dead_band)) continue;
    for (Index k = i; k < end; ++k) stuck.push_back(k);
  }
  if (stuck.empty()) return;
  leaveOut(channel.name,
           fmt::format("{} is stuck (one value for {:.1f} s and longer while the drive moves) in {} rows", channel.name,
                       static_cast<double>(least) * rows.step, stuck.size()),
           stuck, log, faults);
}

/// Exact zeros among values that are far from it.
void findDropouts(const NamedChannel& channel, PreparedLog& log, std::vector<DataFault>& faults) {
  const Index n = channel.values.size();
  const double noise = noiseLevel(std::span<const double>(channel.values.data(), static_cast<std::size_t>(n)));
  std::vector<Index> rows;
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
      for (Index k = i; k < end; ++k) rows.push_back(k);
    }
    i = end;
  }
  if (rows.size() < 3) return;
  leaveOut(channel.name,
           fmt::format("{} drops to exactly 0 and back in {} rows: lost samples", channel.name, rows.size()), rows, log,
           faults);
}

/// Sensors of a spring at their limit, lost samples, and a force that pushes the way it is pushed.
void findSpringFaults(PreparedLog& log, std::vector<DataFault>& faults) {
  const ActuatorRows& rows = log.data.rows;
  const auto all = static_cast<double>(rows.rows());
  for (const ChannelSpikes& clipped : log.clipped) {
    const bool few = static_cast<double>(clipped.rows.size()) <= kMostLeftOut * all;
    faults.push_back({clipped.channel,
                      fmt::format("{} sits at its limit in {} rows while the other channel moves on: saturated{}",
                                  clipped.channel, clipped.rows.size(), few ? "; they were left out" : ""),
                      clipped.rows.front() + 1, clipped.rows.back() + 1, clipped.rows.size(), few});
  }
  findDropouts({log.effort_column, rows.effort}, log, faults);
  const double agreement = correlation(spanOf(rows.effort), spanOf(rows.deflection));
  if (agreement > -kMirrored) return;
  faults.push_back(
      {log.effort_column, fmt::format("{} falls where the deflection grows (correlation {:.2f}): one of the "
                                      "two has the wrong sign",
                                      log.effort_column, agreement)});
}

/// A winding whose current or velocity has the wrong sign.
void findTurnedWinding(const PreparedLog& log, std::vector<DataFault>& faults) {
  const ActuatorRows& rows = log.data.rows;
  if (rows.current.size() == 0) return;
  const std::string sentence = oppositeWindingSign(spanOf(rows.effort), spanOf(rows.current), spanOf(rows.speed));
  if (!sentence.empty()) faults.push_back({log.effort_column, sentence});
}

/// Signs that no drive can have: load that helps to draw current, a joint that turns against its motor.
void findMirrored(const PreparedLog& log, std::vector<DataFault>& faults) {
  const ActuatorRows& rows = log.data.rows;
  const Index n = rows.rows();
  Eigen::MatrixXd x(n, 5);
  x << rows.load, rows.load.abs() * rows.direction, rows.direction, rows.speed, Eigen::ArrayXd::Ones(n);
  for (Index i = 0; i < n; ++i) {
    if (!log.data.keep[i]) x.row(i).setZero();
  }
  const Eigen::VectorXd scale = x.colwise().norm().transpose();
  const Eigen::VectorXd c = solveLeastSquares(x, rows.effort.matrix()).cwiseProduct(scale);
  const double size = (rows.effort - rows.effort.mean()).matrix().norm();
  // Only a load that was measured, and that the effort mirrors as plainly as a plot would show it. A back-driven motor,
  // a damper or a piston under pressure has effort against its speed in all honesty.
  const double agreement = correlation(spanOf(rows.effort), spanOf(rows.load));
  if (rows.top_load > 0.0 && log.data.rig.cols() == 0 && !log.data.angle && c[0] < -0.2 * size &&
      agreement < -kMirrored) {
    faults.push_back({"external_torque",
                      fmt::format("{} falls where the load grows (correlation {:.2f}): one of {} and external_torque "
                                  "has the wrong sign",
                                  log.effort_column, agreement, log.effort_column)});
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

/// Whether the drive keeps its direction from `first` to `last`.
bool keepsDirection(const ActuatorRows& rows, Index first, Index last) {
  return (rows.direction.segment(first, last - first + 1) == rows.direction[first]).all();
}

/// Rows that stand alone, one or a few together: the rows beside them are far smaller. What lasts longer is a misfit.
/// \param far  shape (rows): rows beyond every noise, at a speed
std::vector<Index> standingAlone(const PreparedLog& log, const Eigen::VectorXd& residual,
                                 const std::vector<bool>& far) {
  constexpr Index kMost = 5;         // rows
  constexpr double kBeside = 0.3;    // of the largest of them
  constexpr double kFromTurn = 0.3;  // [s] between a turn and rows together: play and bristles leave bursts, too
  const ActuatorRows& rows = log.data.rows;
  const auto reach = static_cast<Index>(std::ceil(kFromTurn / rows.step));
  std::vector<Index> alone;
  for (Index i = 2, end = 0; i + 2 < residual.size(); i = std::max(end, i + 1)) {
    end = i;
    while (end + 2 < residual.size() && far[end]) ++end;
    if (end == i || end - i > kMost) continue;
    const Index last = end - 1;
    const bool single = last == i, counts = residual[i - 2] != 0.0 && residual[last + 2] != 0.0;
    const Index near = single ? 2 : reach;
    if (!keepsDirection(rows, std::max<Index>(0, i - near), std::min(rows.rows() - 1, last + near))) continue;
    const double around = std::max(std::abs(residual[i - 2]), std::abs(residual[last + 2]));
    if (around >= kBeside * residual.segment(i, end - i).cwiseAbs().maxCoeff() || !(single || counts)) continue;
    for (Index k = i; k < end; ++k) alone.push_back(k);
  }
  return alone;
}

/// The first rows of sessions, up to the last one that is far off there: a recording may begin while a filter settles
/// or a controller is switched on. None where others are far off, too: that is no beginning's.
std::vector<Index> ofBeginnings(const ActuatorRows& rows, const std::vector<bool>& far) {
  constexpr double kBeginning = 0.5;  // [s]
  constexpr double kElsewhere = 0.2;  // of the rows that are far off
  std::vector<Index> first;
  Index all = 0, begun = 0;
  for (Index i = 0, begin = 0, taken = 0; i < rows.rows(); ++i) {
    if (i == 0 || rows.session[i] != rows.session[i - 1]) begin = taken = i;
    if (!far[i]) continue;
    ++all;
    if (rows.time[i] - rows.time[begin] > kBeginning) continue;
    ++begun;
    for (; taken <= i; ++taken) first.push_back(taken);
  }
  if (static_cast<double>(all - begun) > kElsewhere * static_cast<double>(all)) first.clear();
  return first;
}

}  // namespace

std::vector<DataFault> findFaults(PreparedLog& log) {
  const ActuatorRows& rows = log.data.rows;
  std::vector<DataFault> faults;
  for (const LeftOutRows& out : log.left_out) {
    faults.push_back({out.channel, out.sentence + "; they were left out", out.first_row, out.last_row, out.rows, true});
  }
  for (const ChannelSpikes& s : log.spikes) {
    faults.push_back({s.channel, standsAlone(s) + ": outliers; they were left out", s.rows.front() + 1,
                      s.rows.back() + 1, s.rows.size(), true});
  }
  const LogKind& kind = kindOf(log.kind);
  if (kind.checks == FaultChecks::kDeflection) {
    findSpringFaults(log, faults);
    return faults;
  }
  if (kind.checks == FaultChecks::kLevels) {
    const NamedChannel answer{kind.answer, rows.*kind.answers};
    if (rows.timed) findClipping(answer, log, faults);
    findDropouts(answer, log, faults);
    findTurnedWinding(log, faults);
    return faults;
  }
  std::vector<NamedChannel> channels = {{log.effort_column, rows.effort}, {"motor_velocity", rows.speed}};
  if (rows.top_load > 0.0) channels.push_back({"external_torque", rows.load});
  for (const NamedChannel& channel : channels) {
    std::vector<double> limits;
    const bool set = channel.name == "external_torque" && isCoarse(channel);  // weights, and no sensor
    if (!set) limits = findClipping(channel, log, faults);
    findStuck(channel, limits, log, faults);
    findDropouts(channel, log, faults);
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
    log.data.keep[i] = false;
    ++rows;
  }
  return rows;
}

std::vector<DataFault> takeOutSpikes(PreparedLog& log, const Eigen::VectorXd& residual,
                                     const Eigen::VectorXd& flipped) {
  const ActuatorRows& rows = log.data.rows;
  const double limit = kSpike * deviationOf(residual);
  const bool has_speed = (rows.speed != 0.0).any();  // or its model, a muscle's, asks for no direction
  std::vector<bool> far(static_cast<std::size_t>(residual.size()));
  for (Index i = 0; i < residual.size(); ++i) {
    // Of the direction; else neither explains it. Of levels, which have no time, none stands alone.
    const bool sure = has_speed ? std::abs(rows.speed[i]) >= 3.0 * log.dead_band : rows.timed;
    const bool neither = flipped.size() > 0 && std::abs(flipped[i]) > limit && residual[i] * flipped[i] > 0.0;
    far[i] = std::abs(residual[i]) > limit && (sure || neither);
  }
  std::vector<DataFault> faults;
  const auto take = [&](const std::vector<Index>& bad, std::string_view where) {
    if (bad.empty()) return;
    leaveOut(log.effort_column,
             fmt::format("{} rows {} more than {:.0f} robust standard deviations off the model: outliers", bad.size(),
                         where, kSpike),
             bad, log, faults);
    for (const Index i : bad) far[i] = false;
  };
  take(standingAlone(log, residual, far), "stand alone,");
  if (rows.timed) take(ofBeginnings(rows, far), "at the beginning are");
  return faults;
}

}  // namespace simgap
