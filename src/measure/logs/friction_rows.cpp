#include "simgap/measure/logs/friction_rows.h"

#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numeric>

#include "derived_motion.h"
#include "load_noise.h"
#include "parallel_filter.h"
#include "row_faults.h"
#include "simgap/core/error.h"
#include "simgap/measure/logs/channel_checks.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/measure/logs/rests.h"
#include "simgap/measure/logs/rig_load.h"
#include "turns.h"
#include "velocity_scale.h"

namespace simgap {
namespace {

constexpr std::array kChannels = {&FrictionData::time,      &FrictionData::effort,    &FrictionData::velocity,
                                  &FrictionData::log_speed, &FrictionData::direction, &FrictionData::load};
constexpr double kLowestLogSpeed = -600.0;  // exp of it is still a number; log(0) is none

/// Seconds beside a stop or a start that are the smoother's. The acceleration jumps there, of which e^(-pi f t) is left
/// after t: with two periods of its bandwidth f, a five-hundredth, the intervals of a fit hold. A diagnosis keeps most
/// of them, as it finds what it looks for there.
double blurredSeconds(const FrictionData& data, bool derived_velocity, const FrictionDataOptions& options) {
  if (options.all_rows) return derived_velocity ? 0.5 / data.bandwidth : 0.0;
  return data.bandwidth > 0.0 ? 2.0 / data.bandwidth : 0.0;
}

void checkLog(const ActuatorLog& log, FrictionData& data) {
  const std::string effort = quantityName(log.effort_name, log.effort_unit);
  const std::string velocity = quantityName("motor_velocity", log.velocityUnit());
  const double plausible_effort = log.effort_unit == "A" ? 2e3 : log.effort_unit == "V" ? 2e3 : 1e6;
  const ChannelCheck channels[] = {
      {effort, log.effort, plausible_effort},
      {velocity, log.velocity, log.linear ? 1e3 : 2e4},
      {quantityName(log.linear ? "external_force" : "external_torque", log.loadUnit()), log.load, 1e6}};
  for (std::string& warning : checkChannels(log.file, channels)) data.warnings.push_back(std::move(warning));
  if (isConstant(log.effort)) {
    throw DataError(
        fmt::format("{}: {} is {:.4g} in every row, expected what the motor drew while it moved: no "
                    "parameter can be found from this log",
                    log.file, effort, log.effort.front()));
  }
  if (isConstant(log.velocity)) {
    throw DataError(
        fmt::format("{}: {} is {:.4g} in every row, expected motion: friction cannot be found; record slow "
                    "and fast motion in both directions",
                    log.file, velocity, log.velocity.front()));
  }
}

/// A velocity or a position in degrees under a name in radians shows where both are there. Another factor is none of
/// units: the position may be that of another shaft, and friction does not ask for it.
void refuseDegrees(const ActuatorLog& log, std::span<const Block> runs) {
  constexpr double kSlip = 0.03;  // of 1: 57.3 may be the ratio of a gearbox
  if (log.linear || !log.has_time || log.position.empty() || log.velocity.empty()) return;
  const std::optional<VelocityScale> scale = velocityScale(log.time, log.position, log.velocity, runs);
  const std::string slip = scale ? degreesSlip(scale->factor, kSlip) : "";
  if (slip.empty()) return;
  throw DataError(
      fmt::format("{}: found a velocity that is {:.3g} times the slope of the position, expected both in the "
                  "units that their columns say{}",
                  log.file, scale->factor, slip));
}

/// Steady states without times, in any order: of a table there are few rows, or their speeds jump from row to row,
/// which is no noise.
bool areSteadyStates(const ActuatorLog& log, double dead_band_widths) {
  constexpr std::size_t kTable = 100;  // rows; a recording of fewer is over within a second
  constexpr double kJumps = 0.5;       // of the top speed: so wide a dead band leaves little
  if (log.has_time || log.velocity.size() < 3) return false;
  if (log.velocity.size() < kTable) return true;
  return dead_band_widths * noiseLevel(log.velocity) > kJumps * fastSpeed(log.velocity);
}

/// Something has to be left to fit.
void requireRows(const ActuatorLog& log, const MotionSign& sign) {
  if (std::ranges::find(sign.keep, true) != sign.keep.end()) return;
  const double top = std::abs(std::ranges::max(log.velocity, {}, [](double v) { return std::abs(v); }));
  throw DataError(fmt::format(
      "{}: no row of {} is left: the fastest moves at {:.3g} {}, what is within +-{:.3g} counts as rest (from what the "
      "velocity changes by from row to row; --dead-band says another), and starts, stops and turns do not count",
      log.file, log.rows(), top, log.velocityUnit(), sign.dead_band));
}

/// Drops rows channel by channel, in place: the data are the largest thing in memory.
void keepRows(FrictionData& data, const std::vector<bool>& keep) {
  std::size_t kept = 0;
  std::vector<Block> blocks;
  std::size_t block = 0, block_begin = 0;
  const auto closeBlocks = [&](std::size_t row) {
    for (; block < data.blocks.size() && data.blocks[block].end <= row; ++block) {
      if (block_begin < kept) blocks.push_back({block_begin, kept});
    }
  };
  for (std::size_t i = 0; i < keep.size(); ++i) {
    closeBlocks(i);
    if (block < data.blocks.size() && data.blocks[block].begin == i) block_begin = kept;
    if (!keep[i]) continue;
    const Eigen::Index from = i, to = kept;
    for (Eigen::ArrayXd FrictionData::*channel : kChannels) (data.*channel)[to] = (data.*channel)[from];
    for (Eigen::Index k = 0; k < data.load_per.cols(); ++k) data.load_per(to, k) = data.load_per(from, k);
    data.session[kept] = data.session[i];
    data.row[kept] = data.row[i];
    if (!data.keep.empty()) data.keep[kept] = data.keep[i];
    ++kept;
  }
  closeBlocks(keep.size());
  const Eigen::Index n = kept;
  for (Eigen::ArrayXd FrictionData::*channel : kChannels) (data.*channel).conservativeResize(n);
  data.load_per.conservativeResize(n, Eigen::NoChange);
  data.session.resize(kept);
  data.row.resize(kept);
  if (!data.keep.empty()) data.keep.resize(kept);
  data.blocks = std::move(blocks);
}

/// A channel as an array; the vector's memory is given back.
Eigen::ArrayXd take(std::vector<double>& channel) {
  Eigen::ArrayXd values = Eigen::Map<const Eigen::ArrayXd>(channel.data(), channel.size());
  channel = {};
  return values;
}

}  // namespace

Eigen::VectorXd FrictionData::rigCoefficients(std::span<const double> rig) const {
  const Eigen::Map<const Eigen::VectorXd> constants(rig.data(), rig.size());
  if (!fits_angle) return constants;
  const std::size_t angle = angleIndex();
  const double amplitude = angle > 0 ? rig[0] : 1.0;
  Eigen::VectorXd coefficients(load_per.cols());
  coefficients << amplitude * std::cos(rig[angle]), amplitude * std::sin(rig[angle]),
      constants.tail(load_per.cols() - 2);
  return coefficients;
}

std::vector<double> FrictionData::rigConstants(const Eigen::VectorXd& coefficients) const {
  if (!fits_angle) return {coefficients.begin(), coefficients.end()};
  std::vector<double> rig;
  if (angleIndex() > 0) rig.push_back(coefficients.head<2>().norm());
  rig.push_back(std::atan2(coefficients[1], coefficients[0]));
  rig.insert(rig.end(), coefficients.begin() + 2, coefficients.end());
  return rig;
}

Eigen::MatrixXd FrictionData::rigDerivatives(std::span<const double> rig) const {
  const auto k = load_per.cols();
  const Eigen::Index r = rig.size();
  if (!fits_angle) return Eigen::MatrixXd::Identity(k, r);
  Eigen::MatrixXd d = Eigen::MatrixXd::Zero(k, r);
  const std::size_t angle = angleIndex();
  const double c = std::cos(rig[angle]), s = std::sin(rig[angle]), amplitude = angle > 0 ? rig[0] : 1.0;
  if (angle > 0) d.col(0).head<2>() << c, s;
  d.col(angle).head<2>() << -amplitude * s, amplitude * c;
  d.bottomRightCorner(k - 2, k - 2).setIdentity();
  return d;
}

Eigen::ArrayXd FrictionData::totalLoad(std::span<const double> rig) const {
  if (rig_names.empty()) return load;
  return load + (load_per.matrix() * rigCoefficients(rig)).array();
}

FrictionData selectRows(const FrictionData& data, const std::vector<bool>& keep) {
  FrictionData some = data;
  keepRows(some, keep);
  return some;
}

FrictionData prepareFrictionData(ActuatorLog log, const Bench& bench, const FrictionDataOptions& options) {
  FrictionData data;
  data.file = log.file;
  data.log_rows = log.rows();
  data.effort_name = log.effort_name;
  data.effort_unit = log.effort_unit;
  data.angle_unit = log.angleUnit();
  data.velocity_unit = log.velocityUnit();
  data.load_unit = log.loadUnit();
  data.session_names = log.session_names;
  const std::vector<Block> runs = splitRuns(log.time, log.session);
  refuseDegrees(log, runs);
  if (!options.raw_sign) {
    takeEvenTimes(log, runs, bench.needsAcceleration(), data);
    putSpikesRight(log, data);
    if (bench.needsAcceleration()) replaceNoisyVelocity(log, runs, data);
    moveLateVelocity(log, runs, data);
    if (!options.load_is_fitted) smoothNoisyLoad(log, runs, data);
  }
  const bool derived_velocity = log.velocity.empty();
  completeMotion(log, runs, options.bandwidth ? options.bandwidth : bench.bandwidth, bench.needsAcceleration(), data);
  checkLog(log, data);
  workOutLoad(log, bench, data);

  std::optional<double> dead_band = options.dead_band;
  if (derived_velocity && !dead_band) {
    dead_band = derivedDeadBand(log, runs, data.bandwidth, options.dead_band_widths);
  }
  const bool raw = options.raw_sign || (!dead_band && areSteadyStates(log, options.dead_band_widths));
  MotionSign sign = raw ? rawSign(log.velocity) : holdSign(log.velocity, options.dead_band_widths, dead_band);
  data.timed = log.has_time;
  data.dead_band = sign.dead_band;
  data.reversals = sign.reversals;
  const double blurred_seconds = blurredSeconds(data, derived_velocity, options);
  leaveOutRests(log, blurred_seconds, derived_velocity, options, sign, data);
  if (blurred_seconds > 0.0 && !options.raw_sign && !options.all_rows) {
    leaveOutTurns(log.time, runs, blurred_seconds, sign);
  }
  leaveOutSwitchedOff(log, options, sign, data);
  leaveOutSpikes(options, sign, data);
  leaveOutShortRuns(runs, sign, data);
  requireRows(log, sign);
  if (!options.raw_sign) smoothLikeMotion(log, runs, sign, data);
  const std::size_t rows = log.rows();
  data.blocks = splitBlocks(log.time, log.session, options.block_seconds);
  data.block_seconds = options.block_seconds;
  data.time = take(log.time);
  data.effort = take(log.effort);
  data.velocity = take(log.velocity);
  data.direction.resize(rows);
  std::ranges::copy(sign.direction, data.direction.begin());
  data.session = std::move(log.session);
  log = {};
  data.log_speed = data.velocity.abs().log().max(kLowestLogSpeed);
  data.row.resize(rows);
  std::iota(data.row.begin(), data.row.end(), std::size_t{0});
  if (options.all_rows) {
    data.keep = std::move(sign.keep);
    return data;
  }
  const bool all = std::ranges::all_of(sign.keep, [](bool kept) { return kept; });
  if (!all) keepRows(data, sign.keep);
  return data;
}

}  // namespace simgap
