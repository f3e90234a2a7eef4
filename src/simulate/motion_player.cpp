#include "simgap/simulate/motion_player.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/joint_kind.h"
#include "simgap/simulate/equilibrium_arm.h"

namespace simgap {
namespace {

/// The way from one position to another, a part of it.
JointPosition between(const JointPosition& a, const JointPosition& b, double part) {
  return {a.rotation.slerp(part, b.rotation), a.angle + part * (b.angle - a.angle)};
}

/// The commands of a motion at a time that only rises.
class CommandTrack {
 public:
  explicit CommandTrack(const RecordedMotion& motion) : motion_(motion), now_(motion.muscles.size()) {}

  /// Shape (muscles). Before the first row the first commands, behind the last one the last.
  std::span<const double> at(double time) {
    const std::vector<double>& times = motion_.times;
    while (row_ + 1 < times.size() && times[row_ + 1] <= time + kTick) ++row_;
    const bool straight = motion_.interpolated && row_ + 1 < times.size() && time > times[row_];
    const double part = straight ? (time - times[row_]) / (times[row_ + 1] - times[row_]) : 0.0;
    for (std::size_t m = 0; m < now_.size(); ++m) {
      const std::vector<double>& commands = motion_.muscles[m].commands;
      now_[m] = straight ? commands[row_] + part * (commands[row_ + 1] - commands[row_]) : commands[row_];
    }
    return now_;
  }

 private:
  static constexpr double kTick = 1e-9;  // [s]: a row at the time of a step counts for that step
  const RecordedMotion& motion_;
  std::vector<double> now_;
  std::size_t row_ = 0;
};

/// Measures between the states before and after a step in which a measurement falls.
class Recorder {
 public:
  Recorder(const BulletArm& arm, const RecordedMotion& motion, double capture_delay, PlayedMotion& played)
      : arm_(arm), motion_(motion), capture_delay_(capture_delay), played_(played) {
    played_.joints.resize(motion.joint_times.size() * arm.joints());
    played_.shafts.resize(motion.times.size() * arm.muscles());
    played_.currents.resize(motion.times.size() * arm.muscles());
    drives_.resize(2 * arm.muscles());
    drives_before_.resize(2 * arm.muscles());
  }

  /// Whether anything is left to be measured.
  bool more() const { return frame_ < motion_.joint_times.size() || row_ < motion_.times.size(); }

  /// Whether anything is measured up to `time`.
  bool due(double time) const {
    return (frame_ < motion_.joint_times.size() && motion_.joint_times[frame_] + capture_delay_ <= time) ||
           (row_ < motion_.times.size() && motion_.times[row_] <= time);
  }
  /// Before a step in which something is due.
  void notePrevious() {
    before_ = arm_.capturedPositions();
    takeDrives(drives_before_);
  }
  /// Everything due up to `time`, where the arm is now. \param step  since notePrevious() [s]
  void record(double time, double step) {
    joints_ = arm_.capturedPositions();
    takeDrives(drives_);
    const auto part = [&](double at) { return std::clamp(1.0 - (time - at) / step, 0.0, 1.0); };
    while (frame_ < motion_.joint_times.size() && motion_.joint_times[frame_] + capture_delay_ <= time) {
      const double way = part(motion_.joint_times[frame_] + capture_delay_);
      for (std::size_t j = 0; j < joints_.size(); ++j) {
        played_.joints[frame_ * joints_.size() + j] = between(before_[j], joints_[j], way);
      }
      ++frame_;
    }
    const std::size_t muscles = arm_.muscles();
    while (row_ < motion_.times.size() && motion_.times[row_] <= time) {
      const double way = part(motion_.times[row_]);
      for (std::size_t m = 0; m < muscles; ++m) {
        const auto mixed = [&](std::size_t i) { return drives_before_[i] + way * (drives_[i] - drives_before_[i]); };
        played_.shafts[row_ * muscles + m] = mixed(m);
        played_.currents[row_ * muscles + m] = mixed(muscles + m);
      }
      ++row_;
    }
  }

 private:
  void takeDrives(std::vector<double>& drives) const {
    for (std::size_t m = 0; m < arm_.muscles(); ++m) {
      drives[m] = arm_.shaftAngle(m);
      drives[arm_.muscles() + m] = arm_.current(m);
    }
  }

  const BulletArm& arm_;
  const RecordedMotion& motion_;
  double capture_delay_;
  PlayedMotion& played_;
  std::vector<JointPosition> joints_, before_;
  std::vector<double> drives_, drives_before_;
  std::size_t frame_ = 0, row_ = 0;
};

bool fail(const BulletArm& arm, double time, PlayedMotion& played) {
  played.failed_at = time;
  played.worst = 0;
  for (std::size_t j = 1; j < arm.joints(); ++j) {
    const double worst = arm.jointSpeed(static_cast<std::size_t>(played.worst));
    if (!(arm.jointSpeed(j) <= worst)) played.worst = static_cast<int>(j);
  }
  return false;
}

/// Brings the arm to where the motion begins. \returns false when it blew up
bool begin(BulletArm& arm, const RecordedMotion& motion, const MotionOptions& options,
           std::span<const JointPosition> rest, CommandTrack& commands, PlayedMotion& played) {
  const double first = motion.times.front();
  arm.setShaftReferences(commands.at(first));
  arm.placeShafts(motion.start ? std::span<const double>(motion.start->shafts) : commands.at(first));
  arm.setJointPositions(motion.start ? std::span<const JointPosition>(motion.start->joints) : rest);
  if (motion.start) return true;
  const long steps = std::lround(options.settle / options.arm.step);
  for (long i = 0; i < steps; ++i) {
    arm.step();
    if (!arm.isFinite()) return fail(arm, first + static_cast<double>(i - steps) * options.arm.step, played);
  }
  return true;
}

}  // namespace

void playMotion(BulletArm& arm, const RecordedMotion& motion, const MotionOptions& options,
                std::span<const JointPosition> rest, double capture_delay, PlayedMotion& played) {
  played.valid = false;
  arm.reset();
  CommandTrack commands(motion);
  if (!begin(arm, motion, options, rest, commands, played)) return;
  Recorder recorder(arm, motion, capture_delay, played);
  const double step = options.arm.step;
  const double first = motion.times.front();
  recorder.notePrevious();
  recorder.record(first, step);
  for (long i = 0; recorder.more(); ++i) {
    const double now = first + static_cast<double>(i + 1) * step;
    const bool due = recorder.due(now);
    if (due) recorder.notePrevious();
    arm.setShaftReferences(commands.at(now - step));
    arm.step();
    if (!arm.isFinite()) {
      fail(arm, now, played);
      return;
    }
    if (due) recorder.record(now, step);
  }
  played.valid = true;
}

std::vector<JointPosition> restPose(const ArmModel& model, const RecordedMotion& motion) {
  if (motion.start) return motion.start->joints;
  std::vector<double> shafts;
  for (const MuscleRecord& muscle : motion.muscles) {
    if (muscle.kind != CommandKind::kSetpoint) return motion.joints.front();
    shafts.push_back(muscle.commands.front());
  }
  EquilibriumArm arm(model);
  return arm.solveFrom(motion.joints.front(), shafts).stable ? arm.joints() : motion.joints.front();
}

std::string describeFailure(const PlayedMotion& played, const PoseLayout& layout, const MotionOptions& options) {
  return fmt::format(
      "the simulation blew up {:.2f} s after the start ({} fastest); a smaller step than {:g} s may hold",
      played.failed_at, layout.joints[static_cast<std::size_t>(std::max(0, played.worst))].name, options.arm.step);
}

}  // namespace simgap
