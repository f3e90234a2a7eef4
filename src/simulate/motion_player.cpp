#include "simgap/simulate/motion_player.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "position_reach.h"
#include "simgap/core/error.h"
#include "simgap/core/joint_kind.h"
#include "simgap/core/position_bytes.h"
#include "simgap/core/statistics.h"
#include "simgap/measure/motion_restart.h"
#include "simgap/model/arm/arm_effect.h"
#include "simgap/simulate/equilibrium_arm.h"

namespace simgap {
namespace {

/// The moments at which a motion is to be looked at, rising: those of its rows, and of its frames on the rows' clock,
/// with the place of each among them. None is later than `until` on its own clock.
struct Moments {
  std::vector<double> times;
  std::vector<std::size_t> of_row, of_frame;
};
Moments momentsOf(const RecordedMotion& motion, double capture_delay, double until) {
  Moments moments;
  const double first = motion.times().front();
  std::size_t row = 0, frame = 0;
  const auto heldBy = [until](const std::vector<double>& times) {
    return static_cast<std::size_t>(std::ranges::upper_bound(times, until) - times.begin());
  };
  const std::size_t rows = heldBy(motion.times()), frames = heldBy(motion.joint_times);
  while (row < rows || frame < frames) {
    // A frame before the first row sees the arm at rest.
    const double frame_time = frame < frames ? std::max(first, motion.joint_times[frame] + capture_delay) : kInfinity;
    const bool is_row = row < rows && motion.times()[row] <= frame_time;
    (is_row ? moments.of_row : moments.of_frame).push_back(moments.times.size());
    moments.times.push_back(is_row ? motion.times()[row++] : frame_time);
    if (!is_row) ++frame;
  }
  return moments;
}

/// No winding carries more than its stalled motor draws of the supply, and a reversal from full speed twice that.
void refuseImpossibleCurrents(const ArmModel& model, const RecordedMotion& motion) {
  constexpr double kMost = 3.0;     // times the stalled motor's
  constexpr double kLargest = 0.1;  // of the rows: spikes are others
  for (std::size_t m = 0; m < motion.muscles.size(); ++m) {
    std::vector<double> sizes = motion.muscles[m].currents;
    const Motor& motor = model.muscles[m].motor;
    if (sizes.empty() || !(motor.resistance > 0.0) || !(motor.supply_voltage > 0.0)) continue;
    for (double& size : sizes) size = std::abs(size);
    const double large = quantile(std::move(sizes), 1.0 - kLargest), stalled = motor.supply_voltage / motor.resistance;
    if (large <= kMost * stalled) continue;
    throw DataError(
        fmt::format("{}: current_{}_A: found {:.3g} A and more in a tenth of the rows, expected at most "
                    "{:.3g} A, which the motor draws when it is held: are these milliamperes?",
                    motion.muscles_file.string(), model.muscles[m].name, large, stalled));
  }
}

}  // namespace

MotionOptions MotionOptions::read(const YamlNode& node) {
  MotionOptions options;
  options.rollout.step = node.findQuantity("step", "s", kPositive).value_or(options.rollout.step);
  ControllerOptions& controllers = options.rollout.controllers;
  controllers.rate = node.findQuantity("controller_rate", "Hz", kPositive).value_or(controllers.rate);
  if (const auto gain = node.find("shaft_gain_V_rad")) controllers.shaft_gain = gain->number(kPositive);
  options.settle = node.findQuantity("settle", "s", kNonNegative).value_or(options.settle);
  if (const auto restart = node.findQuantity("restart", "s", kNonNegative)) {
    if (*restart > 0.0 && *restart < kShortestRestart) {
      node.fail(fmt::format("found restart_s: {:g}, expected 0 (never) or at least {:g}", *restart, kShortestRestart));
    }
    options.restart = *restart;
  }
  try {
    options.rollout.validate();
  } catch (const ConfigError& error) {
    node.fail(error.what());
  }
  return options;
}

MotionOptions MotionOptions::coarser() const {
  MotionOptions options = *this;
  options.rollout.step *= 2.0;
  const double periods = options.rollout.step * options.rollout.controllers.rate;  // of the controllers in a step
  options.rollout.drive_steps = periods > 1.5 ? 2 : 1;
  try {
    options.rollout.validate();
  } catch (const ConfigError&) {
    return *this;
  }
  return options;
}

std::string MotionOptions::toYaml(const std::string& indent) const {
  return fmt::format(
      "{0}step_s: {1}\n{0}controller_rate_Hz: {2}\n{0}shaft_gain_V_rad: {3}\n{0}settle_s: {4}\n{0}restart_s: {5}\n",
      indent, rollout.step, rollout.controllers.rate, rollout.controllers.shaft_gain, settle, restart);
}

MotionSet readMotionsFor(const ArmModel& model, const YamlNode& root, const std::filesystem::path& file,
                         const TableReader& table, double restart) {
  MotionSet set = readMotionSet(root, file, model.poseLayout(), table);
  for (const RecordedMotion& motion : set.motions) {
    refuseImpossible(model, motion.commands, [&](std::size_t row, const std::string& sentence) {
      throw DataError(fmt::format("{}: at {} s: {}", motion.muscles_file.string(), motion.times()[row], sentence));
    });
    refuseImpossibleCurrents(model, motion);
  }
  refuseMotionsOutOfReach(model, set);
  return restart > 0.0 ? restarted(set, model.poseLayout(), restart) : set;
}

PlayableMotion::PlayableMotion(const RecordedMotion& recorded, const std::vector<Joint>& joints) : motion(&recorded) {
  constexpr std::size_t kFewest = 5;
  const double end = firstChange(recorded);
  std::size_t frames = 0, rows = 1;
  while (frames < recorded.joint_times.size() && recorded.joint_times[frames] < end) ++frames;
  while (rows < recorded.times().size() && recorded.times()[rows] < end) ++rows;
  for (std::size_t j = 0; frames >= kFewest && j < joints.size(); ++j) {
    std::vector<JointPosition> seen;
    for (std::size_t f = 0; f < frames; ++f) seen.push_back(recorded.joints[f][j]);
    rest.push_back(kindOf(joints[j].type).mean(seen));
  }
  const auto mean = [rows](const std::vector<double>& channel) {
    if (channel.empty()) return std::numeric_limits<double>::quiet_NaN();
    return std::accumulate(channel.begin(), channel.begin() + static_cast<std::ptrdiff_t>(rows), 0.0) /
           static_cast<double>(rows);
  };
  for (const MuscleRecord& muscle : recorded.muscles) {
    shafts.push_back(mean(muscle.shafts));
    currents.push_back(mean(muscle.currents));
  }
}

namespace {

/// Where friction holds a shaft beside its set-point is history, but its current tells: i = K_p (ref - phi) / R. [rad]
double restingShaft(const PlayableMotion& playable, std::size_t muscle, const Motor& motor, double shaft_gain) {
  const MotionCommands& commands = playable.motion->commands;
  const double first = commands.values(static_cast<Eigen::Index>(muscle), 0);
  const bool positioned = commands.kinds[muscle] == CommandKind::kSetpoint;
  const double current = playable.currents[muscle], shaft = playable.shafts[muscle];
  if (positioned && !std::isnan(current)) return first - motor.resistance * current / shaft_gain;
  if (!std::isnan(shaft)) return shaft;
  return positioned ? first : 0.0;
}

}  // namespace

MotionPlayer::MotionPlayer(const ArmModel& model, const MotionOptions& options)
    : model_(model), options_(options), rollout_(model, options.rollout) {}

void MotionPlayer::setModel(const ArmModel& model) {
  model_ = model;
  rollout_.setModel(model);
}

MotionStart MotionPlayer::startOf(const PlayableMotion& playable) const {
  const RecordedMotion& motion = *playable.motion;
  MotionStart start;
  start.time = motion.times().front();
  if (motion.start) {
    start.joints = motion.start->joints;
    start.joint_velocities = motion.start->joint_velocities;
    start.shafts = motion.start->shafts;
    return start;
  }
  start.settle = options_.settle;
  for (std::size_t m = 0; m < motion.muscles.size(); ++m) {
    const double gain = options_.rollout.controllers.shaft_gain * rollout_.arm().controllerGain(m);
    start.shafts.push_back(restingShaft(playable, m, model_.muscles[m].motor, gain));
  }
  const Eigen::MatrixXd& commands = motion.commands.values;
  for (Eigen::Index line = std::ssize(motion.muscles); line < commands.rows(); ++line) {
    start.shafts.push_back(commands(line, 0));
  }
  start.joints = playable.rest;
  if (start.joints.empty()) {
    EquilibriumArm arm(model_);
    start.joints = arm.solveFrom(motion.joints.front(), start.shafts).stable ? arm.joints() : motion.joints.front();
  }
  return start;
}

void MotionPlayer::play(const PlayableMotion& playable, double capture_delay, PlayedMotion& played, double until) {
  const RecordedMotion& motion = *playable.motion;
  const MotionStart start = startOf(playable);
  for (const ArmExtension& extension : resolveExtensions(model_)) {
    if (extension.effect->frame_delay) capture_delay += extension.effect->frame_delay(extension.p);
  }
  const Moments moments = momentsOf(motion, capture_delay, until);
  played.outcome = rollout_.run(motion.commands, start, moments.times, track_);
  played.valid = played.outcome.finished;
  if (!played.valid) return;
  const std::size_t joints = model_.joints.size();
  played.joints.resize(moments.of_frame.size() * joints);
  for (std::size_t f = 0; f < moments.of_frame.size(); ++f) {
    std::ranges::copy(track_.jointsAt(moments.of_frame[f]), played.joints.begin() + std::ssize(motion.joints[0]) * f);
  }
  const auto rows = std::ssize(moments.of_row);
  played.shafts.resize(track_.shafts.rows(), rows);
  played.currents.resize(track_.shafts.rows(), rows);
  for (Eigen::Index row = 0; row < rows; ++row) {
    const auto at = static_cast<Eigen::Index>(moments.of_row[row]);
    played.shafts.col(row) = track_.shafts.col(at);
    played.currents.col(row) = track_.currents.col(at);
  }
}

void pack(Bytes& bytes, const PlayedMotion& played) {
  pack(bytes, played.valid);
  pack(bytes, played.outcome.finished);
  pack(bytes, played.outcome.time);
  pack(bytes, played.outcome.joint);
  pack(bytes, played.outcome.muscle);
  pack(bytes, played.outcome.rows);
  pack(bytes, played.joints);
  for (const Eigen::MatrixXd* table : {&played.shafts, &played.currents}) {
    pack(bytes, table->rows());
    pack(bytes, Eigen::VectorXd(table->reshaped()));
  }
}

void unpack(BytesReader& from, PlayedMotion& played) {
  unpack(from, played.valid);
  unpack(from, played.outcome.finished);
  unpack(from, played.outcome.time);
  unpack(from, played.outcome.joint);
  unpack(from, played.outcome.muscle);
  unpack(from, played.outcome.rows);
  unpack(from, played.joints);
  for (Eigen::MatrixXd* table : {&played.shafts, &played.currents}) {
    Eigen::Index rows = 0;
    Eigen::VectorXd numbers;
    unpack(from, rows);
    unpack(from, numbers);
    *table = numbers.reshaped(rows, rows == 0 ? 0 : numbers.size() / rows);
  }
}

std::string describeFailure(const PlayedMotion& played, const PoseLayout& layout, const MotionOptions& options) {
  const MotionOutcome& outcome = played.outcome;
  const std::string what = outcome.joint >= 0    ? layout.joints[outcome.joint].name
                           : outcome.muscle >= 0 ? layout.muscles[outcome.muscle]
                                                 : "the arm";
  return fmt::format(
      "the simulation blew up at {:.2f} s: {}; a step below {:g} s may hold it (step_s of motions: in "
      "--config)",
      outcome.time, what, options.rollout.step);
}

}  // namespace simgap
