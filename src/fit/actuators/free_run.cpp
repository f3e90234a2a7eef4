#include "simgap/fit/actuators/free_run.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/fit/actuators/actuator_model.h"
#include "simgap/fit/actuators/actuator_regression.h"
#include "simgap/measure/logs/log_kind.h"
#include "simgap/measure/logs/rig_load.h"

namespace simgap {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;

/// The bench with what was fitted in numbers.
Bench benchInNumbers(Bench bench, const FittedModel& model) {
  const bool whole = bench.fitsWholeInertia();
  for (const auto& [constant, name] : {std::pair(&Bench::mass, "mass"),
                                       {&Bench::length, "length"},
                                       {&Bench::angle_offset, "angle_offset"},
                                       {&Bench::inertia, "inertia"}}) {
    BenchConstant& value = bench.*constant;
    if (value.fitted && !(whole && constant == &Bench::inertia)) value = {model.value(name), false};
  }
  if (whole) {
    bench.inertia = {model.value("total_inertia") - bench.mass.value * std::pow(bench.length.value, 2), false};
  }
  return bench;
}

struct State {
  double position;  ///< [rad] of the joint, or [m]
  double velocity;  ///< [rad/s] of the motor, or [m/s]
};

/// A drive between two rows of its log.
class FreeDrive {
 public:
  /// \param rows  of the log, as the model's kind sees them
  FreeDrive(const ActuatorModel& subject, const ActuatorLog& log, const ActuatorRows& rows, const Bench& bench)
      : subject_(subject), log_(log), rows_(rows), bench_(bench), ratio_(bench.ratio.value_or(1.0)) {
    const ActuatorData data = at(0, {log.position[0] / ratio_, 0.0}, 1, 0.0);
    theta_ = ActuatorRegression(subject_.base, subject_.effects, data, std::nullopt).thetaOf(subject_.values);
    if (!(effort(0, {log.position[0] / ratio_, 0.0}, 1, 1.0) > effort(0, {log.position[0] / ratio_, 0.0}, 1, 0.0))) {
      throw DataError(log.file + ": found no inertia to move, expected one in --bench RIG.yaml or in the model");
    }
  }

  /// One step of the midpoint rule. A drive that would turn within it stops first. \param row  from which the load and
  /// the temperature are held.
  State step(Index row, const State& s, double effort_now, double effort_mid, double dt) const {
    const double first = acceleration(row, s, effort_now);
    if (s.velocity == 0.0 && first == 0.0) return s;
    const State mid{s.position + 0.5 * dt * s.velocity / ratio_, s.velocity + 0.5 * dt * first};
    const double v = s.velocity + dt * acceleration(row, mid, effort_mid);
    if (s.velocity * v < 0.0) return {s.position + 0.5 * dt * s.velocity / ratio_, 0.0};
    return {s.position + dt * mid.velocity / ratio_, v};
  }

 private:
  /// The log's row, moved to a state.
  ActuatorData at(Index row, const State& s, int direction, double acceleration) const {
    const auto k = static_cast<std::size_t>(row);
    ActuatorLog one;
    one.file = log_.file;
    one.linear = log_.linear;
    one.effort_unit = log_.effort_unit;
    one.session = {0};
    one.session_names = {log_.session_names[log_.session[k]]};
    one.position = {s.position * ratio_};
    one.acceleration = {acceleration};
    if (!log_.load.empty()) one.load = {log_.load[k]};
    FrictionData load;
    workOutLoad(one, bench_, load);
    ActuatorData data;
    data.keep = {true};
    data.effort_unit = log_.effort_unit;
    data.load_unit = log_.loadUnit();
    data.velocity_unit = log_.velocityUnit();
    data.rig.resize(1, 0);
    data.offset = offset_;
    ActuatorRows& rows = data.rows;
    rows.time = ArrayXd::Constant(1, log_.time[k]);
    rows.elapsed = rows_.elapsed.segment(row, 1);
    rows.effort = rows.travel = rows.rest = ArrayXd::Zero(1);
    rows.speed = ArrayXd::Constant(1, s.velocity);
    rows.direction = ArrayXd::Constant(1, direction);
    rows.load = load.load;
    rows.acceleration = ArrayXd::Constant(1, acceleration);
    rows.joint_angle = ArrayXd::Constant(1, s.position);
    if (rows_.temperature.size() > 0) rows.temperature = rows_.temperature.segment(row, 1);
    rows.session = {0};
    return data;
  }

  double effort(Index row, const State& s, int direction, double acceleration) const {
    const ActuatorData data = at(row, s, direction, acceleration);
    return ActuatorRegression(subject_.base, subject_.effects, data, std::nullopt).predict(theta_)[0];
  }

  /// effort(a) = measured, by the secant from a = 0; the friction of some laws grows with the load, so once more.
  double solve(Index row, const State& s, int direction, double measured) const {
    const double at_rest = effort(row, s, direction, 0.0), per_unit = effort(row, s, direction, 1.0) - at_rest;
    const double first = (measured - at_rest) / per_unit;
    return first + (measured - effort(row, s, direction, first)) / per_unit;
  }

  double acceleration(Index row, const State& s, double measured) const {
    if (s.velocity != 0.0) return solve(row, s, s.velocity > 0.0 ? 1 : -1, measured);
    const double forwards = solve(row, s, 1, measured), backwards = solve(row, s, -1, measured);
    return forwards > 0.0 ? forwards : std::min(backwards, 0.0);
  }

  const ActuatorModel& subject_;
  const ActuatorLog& log_;
  const ActuatorRows& rows_;
  Bench bench_;
  double ratio_;
  bool offset_ = std::ranges::find(subject_.values, "offset", &Estimate::name) != subject_.values.end();
  std::vector<double> theta_;
};

void requireMemoryless(const ActuatorModel& subject) {
  if (!kindOf(subject.base.kind).at_joint) {
    throw ConfigError("found a model of no drive with --simulate, expected one of fit-friction or diagnose");
  }
  for (const ActuatorEffect* effect : subject.effects) {
    if (!effect->remembers) continue;
    throw ConfigError(
        fmt::format("found the effect {} in the model, which depends on what was before; expected effects "
                    "of the moment with --simulate",
                    effect->name));
  }
}

}  // namespace

Prediction runFreely(const FittedModel& model, const CsvTable& table, const Bench& given) {
  constexpr double kLongestStep = 2e-3;  // [s]
  ActuatorModel subject = subjectOf(model);
  requireMemoryless(subject);
  const Bench bench = benchInNumbers(given, model);
  const PreparedLog prepared = prepareLog(table, bench, subject.base.kind, {});
  const ActuatorLog log = readActuatorLog(table, {.ratio = bench.ratio.value_or(0.0)});
  if (log.position.empty()) throw DataError(log.file + ":1: found no position, expected it to start the motion from");
  const ActuatorRows& rows = prepared.data.rows;
  const FreeDrive drive(subject, log, rows, bench);
  Prediction result{log.linear ? "position" : "joint_position", log.angleUnit(), log.time, {}, {}, 0};
  State state{};
  for (Index i = 0; i < rows.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    stopIfInterrupted();
    if (i == 0 || log.session[k] != log.session[k - 1]) {
      state = {rows.joint_angle[i], rows.speed[i]};
    } else {
      const double dt = log.time[k] - log.time[k - 1];
      const int steps = std::max(1, static_cast<int>(std::ceil(dt / kLongestStep)));
      const auto effortAt = [&](double share) { return std::lerp(log.effort[k - 1], log.effort[k], share); };
      for (int n = 0; n < steps; ++n) {
        state = drive.step(i - 1, state, effortAt(double(n) / steps), effortAt((n + 0.5) / steps), dt / steps);
      }
    }
    result.predicted.push_back(state.position);
    result.measured.push_back(rows.joint_angle[i]);
  }
  return result;
}

}  // namespace simgap
