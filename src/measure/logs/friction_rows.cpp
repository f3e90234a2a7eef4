#include "simgap/measure/logs/friction_rows.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <numeric>

#include "simgap/core/error.h"
#include "simgap/measure/logs/channel_checks.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/measure/logs/rests.h"
#include "simgap/measure/logs/spikes.h"

namespace simgap {
namespace {

constexpr std::array kChannels = {&FrictionData::time,      &FrictionData::effort,    &FrictionData::velocity,
                                  &FrictionData::log_speed, &FrictionData::direction, &FrictionData::load};
constexpr double kLowestLogSpeed = -600.0;  // exp of it is still a number; log(0) is none

/// Calls `work(begin, end)` for each run of rows of one session.
template <typename Work>
void perSession(const std::vector<int>& session, const Work& work) {
  std::size_t begin = 0;
  for (std::size_t i = 1; i <= session.size(); ++i) {
    if (i < session.size() && session[i] == session[begin]) continue;
    work(begin, i);
    begin = i;
  }
}

/// The same, but also apart where nothing was logged for several steps: nothing is smoothed over such a gap.
template <typename Work>
void perRun(const ActuatorLog& log, const Work& work) {
  constexpr double kGap = 8.0;  // mean steps
  perSession(log.session, [&](std::size_t begin, std::size_t end) {
    const double step =
        (log.time[end - 1] - log.time[begin]) / static_cast<double>(std::max<std::size_t>(end - begin, 2) - 1);
    std::size_t run = begin;
    for (std::size_t i = begin + 1; i < end; ++i) {
      if (log.time[i] - log.time[i - 1] <= kGap * step || i - run < 8 || end - i < 8) continue;
      work(run, i);
      run = i;
    }
    work(run, end);
  });
}

double samplingRate(const ActuatorLog& log) {
  double seconds = 0.0;
  std::size_t steps = 0;
  perSession(log.session, [&](std::size_t begin, std::size_t end) {
    seconds += log.time[end - 1] - log.time[begin];
    steps += end - 1 - begin;
  });
  return seconds > 0.0 ? static_cast<double>(steps) / seconds : 0.0;
}

/// Velocity and acceleration that were not logged, from position, else acceleration from velocity.
void completeMotion(ActuatorLog& log, bool acceleration, FrictionData& data) {
  const bool velocity = log.velocity.empty();
  if (!velocity && !acceleration) return;
  if (!log.has_time) {
    throw DataError(fmt::format("{}: found no time_s, expected it: {} has to be worked out from motion", log.file,
                                velocity ? "velocity" : "acceleration"));
  }
  const bool from_position = !log.position.empty();
  if (velocity) log.velocity.resize(log.rows());
  if (acceleration) log.acceleration.resize(log.rows());
  perRun(log, [&](std::size_t begin, std::size_t end) {
    const std::size_t n = end - begin;
    if (n < 4) {
      throw DataError(fmt::format("{}: session {} has {} rows, expected at least 4 to work out velocities", log.file,
                                  log.session_names[log.session[begin]], n));
    }
    const auto part = [&](const std::vector<double>& all) { return std::span(all).subspan(begin, n); };
    const auto put = [&](const std::vector<double>& values, std::vector<double>& all) {
      std::ranges::copy(values, all.begin() + begin);
    };
    const std::vector<double> speed =
        from_position ? differentiate(part(log.time), smooth(part(log.time), part(log.position), data.bandwidth))
                      : smooth(part(log.time), part(log.velocity), data.bandwidth);
    if (velocity) put(speed, log.velocity);
    if (acceleration) put(differentiate(part(log.time), speed), log.acceleration);
  });
  if (velocity) data.derived.emplace_back("velocity");
  if (acceleration) data.derived.emplace_back("acceleration");
}

/// Samples that stand alone are marked in every channel, and put right in those that are differentiated.
void takeOutSpikes(ActuatorLog& log, FrictionData& data) {
  if (!log.has_time) return;
  const std::string effort = quantityName(log.effort_name, log.effort_unit);
  const std::pair<std::string, std::vector<double>*> channels[] = {{"motor_position", &log.position},
                                                                   {"motor_velocity", &log.velocity},
                                                                   {effort, &log.effort},
                                                                   {"external_torque", &log.load}};
  for (const auto& [name, values] : channels) {
    if (values->empty()) continue;
    std::vector<std::size_t> rows;
    perSession(log.session, [&](std::size_t begin, std::size_t end) {
      const std::span<const double> time = std::span(log.time).subspan(begin, end - begin);
      for (const std::size_t i : repairSpikes(time, std::span(*values).subspan(begin, end - begin)))
        rows.push_back(begin + i);
    });
    if (rows.empty()) continue;
    data.spikes.push_back({name, std::move(rows)});
  }
}

/// Standard deviation of a velocity that was worked out from positions of noise sigma, sampled at f_s and smoothed with
/// gain G = 1 / (1 + (f / B)^6):  sigma_v^2 = 2 sigma^2 / f_s int_0^inf (2 pi f)^2 G^2 df = sigma^2 (2 pi B)^2 pi B /
/// (6 f_s).
double derivedNoise(const ActuatorLog& log, double bandwidth) {
  double sigma = 0.0;
  perSession(log.session, [&](std::size_t begin, std::size_t end) {
    sigma = std::max(sigma, noiseLevel(std::span(log.position).subspan(begin, end - begin)));
  });
  return sigma * 2.0 * std::numbers::pi * bandwidth *
         std::sqrt(std::numbers::pi * bandwidth / (6.0 * samplingRate(log)));
}

void addColumn(FrictionData& data, const Eigen::ArrayXd& per_unit) {
  data.load_per.conservativeResize(per_unit.size(), data.load_per.cols() + 1);
  data.load_per.col(data.load_per.cols() - 1) = per_unit;
}

void addConstant(FrictionData& data, const char* name, const char* unit) {
  data.rig_names.emplace_back(name);
  data.rig_units.emplace_back(unit);
}

void addRigTerm(FrictionData& data, const BenchConstant& constant, const char* name, const char* unit,
                const Eigen::ArrayXd& per_unit) {
  if (!constant.fitted) {
    data.load += constant.value * per_unit;
    return;
  }
  addColumn(data, per_unit);
  addConstant(data, name, unit);
}

/// m g l sin(theta - theta_0) + (m l^2 + J) theta''. \param angle, acceleration  of the pendulum.
void addPendulum(FrictionData& data, const Bench& bench, const Eigen::ArrayXd& angle,
                 const Eigen::ArrayXd& acceleration) {
  const double mass = bench.mass.fitted ? 1.0 : bench.mass.value;
  const double length = bench.length.fitted ? 1.0 : bench.length.value;
  const double moment = mass * length;  // [kg m], per unit of what is fitted of it
  const BenchConstant amplitude{1.0, bench.length.fitted || bench.mass.fitted};
  const auto [name, unit] = bench.length.fitted ? std::pair("length", "m") : std::pair("mass", "kg");
  const Eigen::ArrayXd inertial =
      bench.fitsWholeInertia() ? Eigen::ArrayXd::Zero(angle.size()) : Eigen::ArrayXd(moment * length * acceleration);
  if (bench.angle_offset.fitted) {
    data.fits_angle = true;
    addColumn(data, moment * bench.gravity * angle.sin());
    addColumn(data, -moment * bench.gravity * angle.cos());
    if (amplitude.fitted) addConstant(data, name, unit);
    addConstant(data, "angle_offset", "rad");
    data.load += inertial;
  } else {
    addRigTerm(data, amplitude, name, unit,
               moment * bench.gravity * (angle - bench.angle_offset.value).sin() + inertial);
  }
  addRigTerm(data, bench.inertia, bench.fitsWholeInertia() ? "total_inertia" : "inertia", "kg_m2", acceleration);
}

/// The load of the rig, in the signs of 003 eq. 3: what the motor must overcome in the positive direction.
void workOutLoad(const ActuatorLog& log, const Bench& bench, FrictionData& data) {
  const Eigen::Index n = log.rows();
  const auto column = [n](const std::vector<double>& v) { return Eigen::Map<const Eigen::ArrayXd>(v.data(), n); };
  data.load = Eigen::ArrayXd::Zero(n);
  data.load_per.resize(n, 0);
  if (!log.load.empty()) data.load = column(log.load);
  switch (bench.load) {
    case BenchLoad::kTorqueSensor:
      if (!log.load.empty()) return;
      throw DataError(fmt::format(
          "{}:1: found no external_torque_Nm, expected it, or --bench RIG.yaml that says where the load comes from",
          log.file));
    case BenchLoad::kPendulum: {
      if (log.position.empty()) throw DataError(log.file + ":1: found no position, expected it for a pendulum");
      const double ratio = bench.ratio.value_or(1.0);
      addPendulum(data, bench, column(log.position) / ratio, column(log.acceleration) / ratio);
      return;
    }
    case BenchLoad::kFreeAxis:
      addRigTerm(data, log.linear ? bench.mass : bench.inertia, log.linear ? "mass" : "inertia",
                 log.linear ? "kg" : "kg_m2", column(log.acceleration));
      return;
  }
}

void checkLog(const ActuatorLog& log, FrictionData& data) {
  const std::string effort = quantityName(log.effort_name, log.effort_unit);
  const std::string velocity = quantityName("motor_velocity", log.velocityUnit());
  const double plausible_effort = log.effort_unit == "A" ? 2e3 : log.effort_unit == "V" ? 2e3 : 1e6;
  const ChannelCheck channels[] = {{effort, log.effort, plausible_effort},
                                   {velocity, log.velocity, log.linear ? 1e3 : 2e4},
                                   {quantityName("external_torque", log.loadUnit()), log.load, 1e6}};
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

/// Kinetic laws are fitted and judged on motion.
void leaveOutRests(const ActuatorLog& log, bool derived, const FrictionDataOptions& options, MotionSign& sign,
                   FrictionData& data) {
  constexpr std::ptrdiff_t kFewestRows = 50;  // of motion
  if (options.raw_sign || !log.has_time) return;
  RestRule rule{restingSpeed(log.velocity, sign.dead_band)};
  if (derived) {  // what stands between two positions is known for shorter rests, and their ends are blurred
    rule.least_seconds = 0.1;
    rule.blurred_seconds = 0.5 / data.bandwidth;
  }
  const std::vector<bool> rest = findRests(log.time, log.velocity, log.session, rule);
  std::vector<bool> moving = sign.keep;
  for (std::size_t i = 0; i < rest.size(); ++i) moving[i] = moving[i] && !rest[i];
  const auto rests = std::ranges::count(sign.keep, true) - std::ranges::count(moving, true);
  const auto left = std::ranges::count(moving, true);
  if (rests == 0) return;
  const double share = 100.0 * static_cast<double>(rests) / static_cast<double>(log.rows());
  if (left >= kFewestRows) {
    sign.keep = std::move(moving);
    data.warnings.push_back(
        fmt::format("the drive stands still in {} rows ({:.1f} %): they are left out, because a held "
                    "drive's effort may lie anywhere within its static friction",
                    rests, share));
    return;
  }
  const std::string found = fmt::format("the drive moves in {} of {} rows", left, log.rows());
  if (options.all_rows) {
    throw DataError(
        fmt::format("{}: {}, expected at least {}: no cause can be told from what holds it; record motion in "
                    "both directions",
                    log.file, found, kFewestRows));
  }
  data.warnings.push_back(found + ": its rests were fitted, too, and a held drive's effort is no friction in motion");
}

std::vector<bool> chosenSessions(const ActuatorLog& log, const std::vector<std::string>& names) {
  if (names.empty()) return std::vector<bool>(log.session_names.size(), true);
  std::vector<bool> chosen(log.session_names.size(), false);
  for (const std::string& name : names) {
    const auto found = std::ranges::find(log.session_names, name);
    if (found == log.session_names.end()) {
      throw DataError(fmt::format("{}: found no session {}, expected one of {}", log.file, name,
                                  fmt::join(log.session_names, ", ")));
    }
    chosen[found - log.session_names.begin()] = true;
  }
  return chosen;
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
  const Eigen::ArrayXd values = Eigen::Map<const Eigen::ArrayXd>(channel.data(), channel.size());
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
  const bool derives = log.velocity.empty() || bench.needsAcceleration();
  if (derives) {
    data.bandwidth = options.bandwidth.value_or(
        bench.bandwidth.value_or(FrictionDataOptions::kDefaultBandwidth * samplingRate(log)));
  }
  const bool derived_velocity = log.velocity.empty();
  if (!options.raw_sign) takeOutSpikes(log, data);
  completeMotion(log, bench.needsAcceleration(), data);
  checkLog(log, data);
  workOutLoad(log, bench, data);

  std::optional<double> dead_band = options.dead_band;
  if (derived_velocity && !dead_band) {
    dead_band = options.dead_band_widths * std::max(noiseLevel(log.velocity), derivedNoise(log, data.bandwidth));
  }
  MotionSign sign =
      options.raw_sign ? rawSign(log.velocity) : holdSign(log.velocity, options.dead_band_widths, dead_band);
  data.dead_band = sign.dead_band;
  data.reversals = sign.reversals;
  leaveOutRests(log, derived_velocity, options, sign, data);
  for (const ChannelSpikes& spikes : data.spikes) {
    for (const std::size_t i : spikes.rows) sign.keep[i] = false;
    if (options.all_rows) continue;  // whoever asked for all rows says it himself
    data.warnings.push_back(fmt::format("{} stands alone in {} rows (the first is row {}): they are left out",
                                        spikes.channel, spikes.rows.size(), spikes.rows.front() + 1));
  }
  const std::vector<bool> chosen = chosenSessions(log, options.sessions);
  for (std::size_t i = 0; i < log.rows(); ++i) {
    if (!chosen[log.session[i]]) sign.keep[i] = false;
  }
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
