#include "simgap/simulate/rollout.h"

#include <fmt/format.h>

#include <algorithm>
#include <cassert>
#include <cmath>

#include "controllers/joint_position.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/arm_effect.h"

namespace simgap {
namespace {

BulletArmOptions armOptions(const RolloutOptions& options) {
  BulletArmOptions arm;
  arm.step = options.step;
  arm.controller_rate = options.controllers.rate / options.drive_steps;
  arm.drive_steps = options.drive_steps;
  arm.shaft_gain = options.controllers.shaft_gain;
  return arm;
}

/// No line winds a motor so fast that its current is this many times that of its stall; a simulation that blows up on a
/// joint's stop passes it, though the joint never runs away.
constexpr double kMostStallCurrents = 50.0;

bool driveIsSound(const BulletArm& arm, const Motor& motor, std::size_t muscle) {
  return std::abs(arm.current(muscle)) * motor.resistance < kMostStallCurrents * motor.supply_voltage &&
         std::isfinite(arm.shaftAngle(muscle)) && std::isfinite(arm.force(muscle));
}

/// By how much commands act late [s].
double commandDelay(const ArmModel& model) {
  double delay = 0.0;
  for (const ArmExtension& extension : resolveExtensions(model)) {
    if (extension.effect->command_delay) delay += extension.effect->command_delay(extension.p);
  }
  return delay;
}

}  // namespace

/// All that a track holds of one moment.
struct Rollout::Sample {
  std::vector<JointPosition> joints;
  std::vector<Eigen::Vector3d> joint_velocities;
  Eigen::VectorXd shafts, shaft_velocities, cord_lengths, forces, currents, voltages, line_commands, line_forces;

  Sample(std::size_t joint_count, std::size_t muscles, std::size_t lines)
      : joints(joint_count), joint_velocities(joint_count) {
    for (Eigen::VectorXd* values : {&line_commands, &line_forces}) values->resize(static_cast<Eigen::Index>(lines));
    for (Eigen::VectorXd* values : {&shafts, &shaft_velocities, &cord_lengths, &forces, &currents, &voltages}) {
      values->resize(static_cast<Eigen::Index>(muscles));
    }
  }
};

void RolloutOptions::validate() const {
  armOptions(*this).validate();
  if (drive_steps != 1 && std::abs(controllers.rate * step - drive_steps) > 1e-6) {
    throw ConfigError(
        fmt::format("drive_steps: found {}, expected 1 where a step is no such multiple of the controllers' "
                    "period",
                    drive_steps));
  }
}

void MotionTrack::resize(std::size_t rows, std::size_t joints_of_arm, std::size_t muscles, std::size_t lines) {
  joint_count = joints_of_arm;
  times.resize(rows);
  joints.resize(rows * joint_count);
  joint_velocities.resize(rows * joint_count);
  for (Eigen::MatrixXd* values : {&shafts, &shaft_velocities, &cord_lengths, &forces, &currents, &voltages}) {
    values->resize(static_cast<Eigen::Index>(muscles), static_cast<Eigen::Index>(rows));
  }
  for (Eigen::MatrixXd* values : {&line_commands, &line_forces}) {
    values->resize(static_cast<Eigen::Index>(lines), static_cast<Eigen::Index>(rows));
  }
}

Rollout::Rollout(const ArmModel& model, const RolloutOptions& options)
    : options_(options), arm_(model, armOptions(options)), muscles_(model.muscles) {
  for (const Joint& joint : model.joints) types_.push_back(joint.type);
  delay_ = commandDelay(model);
  commands_.resize(muscles_.size() + arm_.lines());
  later_.resize(commands_.size());
  before_ = std::make_unique<Sample>(types_.size(), muscles_.size(), arm_.lines());
  now_ = std::make_unique<Sample>(types_.size(), muscles_.size(), arm_.lines());
  if (options.targets) {
    pilot_ = std::make_unique<JointPositionController>(model, options.targets, options.controllers);
  }
  tick_ = static_cast<int>(std::lround(options.drive_steps / (options.controllers.rate * options.step)));
}

Rollout::~Rollout() = default;
Rollout::Rollout(Rollout&&) noexcept = default;
Rollout& Rollout::operator=(Rollout&&) noexcept = default;

void Rollout::setModel(const ArmModel& model) {
  assert(model.muscles.size() == muscles_.size() && model.joints.size() == types_.size());
  arm_.setModel(model);
  muscles_ = model.muscles;
  controllers_.clear();  // a controller may be made for its muscle
  delay_ = commandDelay(model);
  if (pilot_) pilot_ = std::make_unique<JointPositionController>(model, options_.targets, options_.controllers);
}

void Rollout::prepare(std::span<const CommandKind> kinds) {
  assert(kinds.size() == muscles_.size());
  if (controllers_.empty() || !std::ranges::equal(kinds, kinds_)) {
    kinds_.assign(kinds.begin(), kinds.end());
    controllers_.clear();
    for (std::size_t m = 0; m < muscles_.size(); ++m) {
      controllers_.push_back(makeController(kinds_[m], muscles_[m], options_.controllers));
    }
  }
  for (const auto& controller : controllers_) controller->reset();
}

void Rollout::begin(std::span<const CommandKind> kinds, const MotionStart& start) {
  prepare(kinds);
  arm_.reset();
  if (!start.joints.empty()) arm_.setJointPositions(start.joints);
  if (!start.shafts.empty()) arm_.setShafts(start.shafts);
  for (std::size_t j = 0; j < start.joint_velocities.size(); ++j) arm_.setJointVelocity(j, start.joint_velocities[j]);
  // A whole number of controller periods, so that a tick falls on start.time.
  const long ticks = std::lround(std::ceil(start.settle * options_.controllers.rate / options_.drive_steps - 1e-9));
  steps_ = -ticks * tick_;
  origin_ = start.time;
}

double Rollout::time() const { return origin_ + static_cast<double>(steps_) * options_.step; }

void Rollout::control(std::span<const double> commands) {
  for (std::size_t m = 0; m < muscles_.size(); ++m) {
    MuscleSensors sensors;
    sensors.shaft = arm_.shaftAngle(m);
    sensors.shaft_velocity = arm_.shaftVelocity(m);
    sensors.force = arm_.force(m);
    sensors.current = arm_.current(m);
    sensors.cord_expansion = arm_.cordLength(m) - muscles_[m].shock_cord.rest_length;
    const double gain = kinds_[m] == CommandKind::kSetpoint ? arm_.controllerGain(m) : 1.0;
    arm_.setVoltage(m, gain * controllers_[m]->voltage(commands[m], sensors));
  }
  arm_.setLineCommands(commands.subspan(muscles_.size()), false);
}

bool Rollout::step(std::span<const double> commands) {
  if (steps_ % tick_ == 0) control(commands);
  arm_.stepMotion();
  ++steps_;
  return isSound();
}

/// A step under the commands of its moment, and where the drives are finer, of its middle, too.
bool Rollout::follow(const MotionCommands& commands, std::size_t& row) {
  const double now = std::max(origin_, time());  // before a motion begins its first commands act
  if (steps_ % tick_ == 0) commandAt(now, commands, row);
  if (options_.drive_steps == 1) return step(commands_);
  control(commands_);
  arm_.moveBodies();
  arm_.stepDrives(0);
  commandAt(std::max(origin_, time() + 0.5 * options_.step), commands, row);
  control(commands_);
  arm_.stepDrives(1);
  ++steps_;
  return isSound();
}

bool Rollout::isSound() const {
  for (std::size_t m = 0; m < muscles_.size(); ++m) {
    if (!driveIsSound(arm_, muscles_[m].motor, m)) return false;
  }
  return arm_.isFinite();
}

void Rollout::commandAt(double time, const MotionCommands& commands, std::size_t& row) {
  if (pilot_) {
    pilot_->forces(time, arm_, commands_);
  } else if (delay_ == 0.0) {
    commands.at(time, row, commands_);
  } else {
    // Between the two ticks it falls between, so that a search sees a part of a tick.
    const double period = static_cast<double>(tick_) * options_.step / options_.drive_steps, ticks = delay_ / period;
    const double whole = std::floor(ticks), part = ticks - whole;
    commands.at(time - whole * period, row, commands_);
    std::size_t earlier = row > 0 ? row - 1 : 0;
    commands.at(time - (whole + 1.0) * period, earlier, later_);
    for (std::size_t i = 0; i < commands_.size(); ++i) commands_[i] += part * (later_[i] - commands_[i]);
  }
}

MotionOutcome Rollout::run(const MotionCommands& commands, const MotionStart& start, std::span<const double> times,
                           MotionTrack& track) {
  assert(times.empty() || times.front() >= start.time);
  if (track.times.size() != times.size() || track.joint_count != types_.size() ||
      track.shafts.rows() != std::ssize(muscles_) ||
      static_cast<std::size_t>(track.line_commands.rows()) != arm_.lines()) {
    track.resize(times.size(), types_.size(), muscles_.size(), arm_.lines());
  }
  std::ranges::copy(times, track.times.begin());
  begin(commands.kinds, start);
  std::size_t command_row = 0, row = 0;
  commandAt(start.time, commands, command_row);
  arm_.setLineCommands(std::span<const double>(commands_).subspan(muscles_.size()), true);
  while (steps_ < 0) {
    stopIfInterrupted();
    if (!follow(commands, command_row)) return stopped();
  }
  const bool settled = start.settle > 0.0;
  if (settled) {
    take(*now_);
    for (; row < times.size() && times[row] <= start.time; ++row) write(1.0, track, row);
  }
  while (row < times.size()) {
    stopIfInterrupted();
    const double from = time(), to = from + options_.step;
    const bool wanted = times[row] <= to;
    if (wanted) take(*before_);
    if (!follow(commands, command_row)) {
      MotionOutcome outcome = stopped();
      outcome.rows = row;
      return outcome;
    }
    if (!wanted) continue;
    take(*now_);
    // What lines do where a step begins is worked out in that step: of a start that nothing settled, in the first.
    if (!settled && steps_ == 1) {
      before_->cord_lengths = now_->cord_lengths;
      before_->forces = now_->forces;
      before_->line_forces = now_->line_forces;
    }
    for (; row < times.size() && times[row] <= to; ++row) write((times[row] - from) / options_.step, track, row);
  }
  return {true, time(), -1, -1, row};
}

void Rollout::take(Sample& sample) {
  arm_.capturedPositions(sample.joints);
  for (std::size_t j = 0; j < types_.size(); ++j) sample.joint_velocities[j] = arm_.jointVelocity(j);
  for (std::size_t m = 0; m < muscles_.size(); ++m) {
    const auto i = static_cast<Eigen::Index>(m);
    sample.shafts[i] = arm_.shaftAngle(m);
    sample.shaft_velocities[i] = arm_.shaftVelocity(m);
    sample.cord_lengths[i] = arm_.cordLength(m);
    sample.forces[i] = arm_.force(m);
    sample.currents[i] = arm_.current(m);
    sample.voltages[i] = arm_.voltage(m);
  }
  for (std::size_t l = 0; l < arm_.lines(); ++l) {
    sample.line_commands[l] = arm_.lineCommand(l);
    sample.line_forces[l] = arm_.lineForce(l);
  }
}

void Rollout::write(double part, MotionTrack& track, std::size_t row) const {
  const auto column = static_cast<Eigen::Index>(row);
  for (std::size_t j = 0; j < types_.size(); ++j) {
    const std::size_t at = row * types_.size() + j;
    track.joints[at] =
        part >= 1.0 ? now_->joints[j] : kindOf(types_[j]).between(before_->joints[j], now_->joints[j], part);
    track.joint_velocities[at] =
        part >= 1.0 ? now_->joint_velocities[j]
                    : Eigen::Vector3d(before_->joint_velocities[j] +
                                      part * (now_->joint_velocities[j] - before_->joint_velocities[j]));
  }
  const auto blend = [&](Eigen::MatrixXd& out, const Eigen::VectorXd& before, const Eigen::VectorXd& now) {
    if (part >= 1.0) {
      out.col(column) = now;
    } else {
      out.col(column) = before + part * (now - before);
    }
  };
  blend(track.shafts, before_->shafts, now_->shafts);
  blend(track.shaft_velocities, before_->shaft_velocities, now_->shaft_velocities);
  blend(track.cord_lengths, before_->cord_lengths, now_->cord_lengths);
  blend(track.forces, before_->forces, now_->forces);
  blend(track.currents, before_->currents, now_->currents);
  track.voltages.col(column) = now_->voltages;
  blend(track.line_commands, before_->line_commands, now_->line_commands);
  blend(track.line_forces, before_->line_forces, now_->line_forces);
}

MotionOutcome Rollout::stopped() const {
  MotionOutcome outcome{false, time(), -1, -1, 0};
  for (std::size_t j = 0; j < types_.size() && outcome.joint < 0; ++j) {
    if (!arm_.jointIsFinite(j)) outcome.joint = static_cast<int>(j);
  }
  for (std::size_t m = 0; m < muscles_.size() && outcome.joint < 0 && outcome.muscle < 0; ++m) {
    if (!driveIsSound(arm_, muscles_[m].motor, m)) outcome.muscle = static_cast<int>(m);
  }
  return outcome;
}

}  // namespace simgap
