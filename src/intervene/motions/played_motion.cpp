#include "played_motion.h"

#include <fmt/format.h>

#include <cmath>

#include "simgap/simulate/simulation.h"

namespace simgap {
namespace {

using Eigen::Index;

constexpr double kFrameTime = 1.0 / 30;  // [s] of a foreseen capture

MotionStart startOf(const MotionEvidence& evidence, const ArmModel& model, const MotionCommands& commands) {
  return restUnder(model, commands, commands.times.front(), evidence.config.motions.motion.settle);
}

MotionTrack played(const MotionEvidence& evidence, const ArmModel& model, const MotionCommands& commands,
                   const MotionStart& start, const std::vector<double>& times) {
  SimulationOptions options;
  options.rollout = evidence.config.motions.motion.rollout;
  return playAt(model, commands, start, times, options);
}

/// "81.2 N of biceps", where the largest row of a track exceeds a limit. \param rows  shape (muscles, times)
std::string beyond(const Eigen::MatrixXd& rows, const std::vector<Muscle>& muscles, double limit, const char* unit) {
  if (!std::isfinite(limit) || rows.size() == 0) return "";
  Index muscle = 0, time = 0;
  const double largest = rows.cwiseAbs().maxCoeff(&muscle, &time);
  if (largest <= limit) return "";
  return fmt::format("{:.3g} {} of {}", largest, unit, muscles[static_cast<std::size_t>(muscle)].name);
}

}  // namespace

RecordedMotion playedAsRecorded(const MotionEvidence& evidence, const ArmChanges& change,
                                const PlannedMotion& planned) {
  ArmModel model = evidence.candidates.front().model;
  change.apply(model);
  const MotionCommands& commands = planned.commands;
  RecordedMotion motion;
  motion.name = planned.name;
  motion.commands = commands;
  for (double time = commands.times.front(); time <= commands.end(); time += kFrameTime) {
    motion.joint_times.push_back(time);
  }
  const MotionStart start = startOf(evidence, model, commands);
  const MotionTrack frames = played(evidence, model, commands, start, motion.joint_times);
  for (std::size_t f = 0; f < motion.joint_times.size(); ++f) {
    const std::span<const JointPosition> joints = frames.jointsAt(f);
    motion.joints.emplace_back(joints.begin(), joints.end());
  }
  const MotionTrack rows = played(evidence, model, commands, start, commands.times);
  for (Index m = 0; m < rows.shafts.rows(); ++m) {
    MuscleRecord& record = motion.muscles.emplace_back();
    record.shafts.assign(rows.shafts.cols(), 0.0);
    record.currents = record.shafts;
    Eigen::VectorXd::Map(record.shafts.data(), rows.shafts.cols()) = rows.shafts.row(m);
    Eigen::VectorXd::Map(record.currents.data(), rows.shafts.cols()) = rows.currents.row(m);
  }
  return motion;
}

std::string beyondLimits(const MotionEvidence& evidence, const PlannedMotion& planned, const MotionLimits& limits) {
  const MotionCommands& commands = planned.commands;
  const double duration = commands.end() - commands.times.front();
  if (duration > limits.duration) return fmt::format("{:.3g} s", duration);
  if (!std::isfinite(limits.tension) && !std::isfinite(limits.current)) return "";
  const ArmModel& model = evidence.candidates.front().model;
  const MotionTrack track = played(evidence, model, commands, startOf(evidence, model, commands), commands.times);
  const std::string tension = beyond(track.forces, model.muscles, limits.tension, "N");
  return tension.empty() ? beyond(track.currents, model.muscles, limits.current, "A") : tension;
}

}  // namespace simgap
