#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>
#include <cmath>

#include "prepared_rows.h"
#include "simgap/core/decompositions.h"
#include "simgap/core/statistics.h"
#include "simgap/core/units.h"
#include "simgap/measure/logs/motion.h"
#include "simgap/measure/logs/resolution.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

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

/// The smoothing of a measured speed before it is differentiated again, or that which it came from positions with.
double speedBandwidth(const FrictionData& friction, const ActuatorRows& rows) {
  if (friction.bandwidth > 0.0) return friction.bandwidth;
  const std::vector<Block> runs = splitRuns(spanOf(rows.time), rows.session);
  return smoothingBandwidth(spanOf(rows.time), spanOf(rows.speed), runs,
                            FrictionDataOptions::kDefaultBandwidth / rows.step);
}

/// The noise of a torque sensor on which nothing acts is no load: k_a would be whatever makes it explain a little.
void dropNoiseOfLoad(const ActuatorLog& drive, ActuatorRows& rows, std::vector<std::string>& warnings) {
  constexpr double kNoise = 4.0;  // standard deviations: nearly the whole range of noise about nothing
  if (drive.load.empty()) return;
  const ArrayXd sizes = rows.load.abs();
  const double top = quantile({sizes.begin(), sizes.end()}, 0.995), noise = noiseLevel(spanOf(rows.load));
  if (top == 0.0 || top > kNoise * noise) return;
  rows.load.setZero();
  warnings.push_back(
      fmt::format("the load never leaves its sensor's noise ({:.2g}): it is taken for none, and torques "
                  "are told in what the motor draws",
                  noise));
}

/// Where the fit of an angle offset begins: effort by linear least squares from sine, cosine, the other loads,
/// direction, speed and an offset.
double firstAngle(const FrictionData& friction) {
  const Index n = friction.time.size(), k = friction.load_per.cols();
  Eigen::MatrixXd x(n, k + 4);
  x << friction.load_per, friction.load, friction.direction, friction.velocity, ArrayXd::Ones(n);
  for (Index i = 0; i < n; ++i) {
    if (!friction.keep[i]) x.row(i).setZero();
  }
  const Eigen::VectorXd c = solveLeastSquares(x, friction.effort.matrix());
  return std::atan2(c[1], c[0]);
}

/// The rig's unknown constants as columns, and the angle of its pendulum.
void addRig(const FrictionData& friction, ActuatorData& data) {
  data.rig = friction.load_per;
  for (std::size_t k = 0; k < friction.rig_names.size(); ++k) {
    if (friction.fits_angle && k == friction.angleIndex()) continue;
    data.rig_parameters.push_back({friction.rig_names[k], friction.rig_units[k]});
  }
  if (!friction.fits_angle) return;
  data.angle =
      RigAngle{friction.load_per.col(0), friction.load_per.col(1), firstAngle(friction), friction.angleIndex() > 0};
  const ArrayXd weight = data.angle->load(data.angle->start);
  const Index scaled = data.angle->scaled ? 1 : 0, others = friction.load_per.cols() - 2;
  data.rig.resize(weight.size(), scaled + others);
  data.rig.rightCols(others) = friction.load_per.rightCols(others);
  if (data.angle->scaled) {
    data.rig.col(0) = weight;
  } else {
    data.rows.load += weight;
  }
}

}  // namespace

PreparedLog prepareDrive(const CsvTable& table, const Bench& bench, const FrictionDataOptions& given) {
  FrictionDataOptions options = given;
  options.all_rows = true;
  const ActuatorLogOptions log_options{.ratio = bench.ratio.value_or(0.0)};
  const ActuatorLog drive = readActuatorLog(table, log_options);
  options.block_seconds = blockSecondsOf(drive.time, drive.session);
  const FrictionData friction = prepareFrictionData(drive, bench, options);
  PreparedLog log;
  log.file = friction.file;
  log.effort_column = quantityName(friction.effort_name, friction.effort_unit);
  log.session_names = friction.session_names;
  log.dead_band = friction.dead_band;
  if (friction.bandwidth > 0.0) log.blurred_seconds = 1.0 / friction.bandwidth;
  log.warnings = friction.warnings;
  if (!friction.derived.empty()) {
    log.warnings.push_back(fmt::format(
        "{} {} worked out, smoothed to {:.3g} Hz (bandwidth_Hz of a bench file states it)",
        fmt::join(friction.derived, " and "), friction.derived.size() > 1 ? "were" : "was", friction.bandwidth));
  }
  log.spikes = friction.spikes;
  log.blocks = friction.blocks;
  ActuatorData& data = log.data;
  data.keep = friction.keep;
  data.load_unit = friction.load_unit;
  data.effort_unit = friction.effort_unit;
  data.velocity_unit = friction.velocity_unit;
  data.fits_weight = friction.fits_weight;
  data.load_noise = friction.load_noise;
  ActuatorRows& rows = data.rows;
  rows.time = friction.time;
  rows.effort = friction.effort;
  rows.speed = friction.velocity;
  rows.load = friction.load;
  rows.session = friction.session;
  rows.direction = friction.direction;
  fillDirection(rows);
  rows.step = medianStep(rows);
  rows.elapsed = elapsedOf(rows.time, rows.session);
  leaveOutUncertainReversals(rows, log.dead_band, data.keep);
  dropNoiseOfLoad(drive, rows, log.warnings);
  addRig(friction, data);
  rows.top_speed = rows.speed.abs().maxCoeff();
  rows.top_load = rows.load.abs().maxCoeff();
  rows.load_measured = !drive.load.empty();
  rows.acceleration = slopeOf(rows, rows.speed, options.bandwidth.value_or(speedBandwidth(friction, rows)));
  rows.travel = travelOf(rows);
  rows.rest = restOf(rows, log.dead_band);
  rows.turns = !drive.linear;
  if (!drive.linear) {
    rows.joint_angle = optional(table, "joint_position", "rad", log);
    rows.motor_angle = optional(table, "motor_position", "rad", log);
  }
  if (rows.joint_angle.size() == 0 && !drive.position.empty()) {
    rows.joint_angle = toArray(drive.position) / (log_options.ratio > 0.0 ? log_options.ratio : 1.0);
  }
  rows.temperature = optional(table, "temperature", "degC", log);
  addContext(table, log);
  addContext(log, "motor_velocity", rows.speed);
  addContext(log, "external_torque", rows.load);
  if (drive.linear && rows.joint_angle.size() > 0) addContext(log, "position_m", rows.joint_angle);
  addContext(log, "time", rows.elapsed);
  return log;
}

}  // namespace simgap
