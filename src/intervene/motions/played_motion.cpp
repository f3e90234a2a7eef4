#include "played_motion.h"

#include "simgap/simulate/simulation.h"

namespace simgap {
namespace {

using Eigen::Index;

constexpr double kFrameTime = 1.0 / 30;  // [s] of a foreseen capture

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
  const MotionOptions& playing = evidence.config.motions.motion;
  SimulationOptions options;
  options.rollout = playing.rollout;
  const MotionStart start = restUnder(model, commands, commands.times.front(), playing.settle);
  const MotionTrack frames = playAt(model, commands, start, motion.joint_times, options);
  for (std::size_t f = 0; f < motion.joint_times.size(); ++f) {
    const std::span<const JointPosition> joints = frames.jointsAt(f);
    motion.joints.emplace_back(joints.begin(), joints.end());
  }
  const MotionTrack rows = playAt(model, commands, start, commands.times, options);
  for (Index m = 0; m < rows.shafts.rows(); ++m) {
    MuscleRecord& record = motion.muscles.emplace_back();
    record.shafts.assign(rows.shafts.cols(), 0.0);
    record.currents = record.shafts;
    Eigen::VectorXd::Map(record.shafts.data(), rows.shafts.cols()) = rows.shafts.row(m);
    Eigen::VectorXd::Map(record.currents.data(), rows.shafts.cols()) = rows.currents.row(m);
  }
  return motion;
}

}  // namespace simgap
