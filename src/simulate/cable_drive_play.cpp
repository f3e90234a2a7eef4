#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/simulate/cable_drive_motion.h"
#include "simgap/simulate/tick_steps.h"
#include "told_channels.h"

namespace simgap {
namespace {

const std::vector<CommandChannel> kPositionOfDrive = {{"position", "rad"}, {"external_torque", "Nm"}};
const std::vector<CommandChannel> kTorqueOfDrive = {{"torque", "Nm"}, {"external_torque", "Nm"}};

/// The drive's electronics: encoder, trapezoids and controller, tick by tick.
class DriveElectronics {
 public:
  DriveElectronics(const CableDrive& drive, const FrictionCompensation& compensation, bool torque, double start)
      : drive_(drive),
        torque_(torque),
        trapezoid_(drive.velocity, drive.acceleration),
        observer_(drive.observer),
        controller_(drive.control, compensation.drive, compensation.share) {
    trapezoid_.reset(start);
  }
  void reset(double motor) { observer_.reset(motor); }

  /// \param told  the last set-point [rad] or [N m] \returns the current [A]
  double tick(double told, double motor) {
    const double dt = 1.0 / drive_.rate;
    observer_.update(read(motor), dt);
    if (torque_) return controller_.give(told, observer_.velocity());
    trapezoid_.update(told, dt);
    const double position = trapezoid_.position();
    return controller_.follow(position, trapezoid_.velocity(), drive_.weightAt(position), observer_.angle(),
                              observer_.velocity(), dt);
  }
  double reference(double told) const { return torque_ ? told : trapezoid_.position(); }

 private:
  double read(double angle) const {
    if (drive_.counts == 0.0) return angle;
    const double count = 2.0 * std::numbers::pi / drive_.counts;
    return count * std::round(angle / count);
  }

  const CableDrive& drive_;
  bool torque_;
  Trapezoid trapezoid_;
  VelocityObserver observer_;
  TrajectoryController controller_;
};

/// From when on the commands keep their last value [s].
double restBegins(const MotionCommands& commands) {
  Eigen::Index last = commands.values.cols() - 1;
  while (last > 0 && commands.values(0, last - 1) == commands.values(0, commands.values.cols() - 1)) --last;
  return commands.times[last];
}

/// One tick as it is judged.
struct TickOfDrive {
  double time, told, reference, joint, motor, velocity, torque, current;
};

/// Sums over the ticks.
class DriveJudge {
 public:
  /// \param rest  when the path has ended [s]
  DriveJudge(bool torque, double limit, double rest, double end) : torque_(torque), limit_(limit), end_(end) {
    constexpr double kShortestRest = 2.0;  // [s]
    if (!torque && end - rest >= kShortestRest) watched_ = 0.5 * (rest + end);
  }

  void add(const TickOfDrive& tick) {
    const double error = torque_ ? tick.torque - tick.told : tick.joint - tick.reference;
    sums_.rms += error * error;
    sums_.largest = std::max(sums_.largest, std::abs(error));
    sums_.trajectory += std::pow(tick.reference - tick.told, 2);
    sums_.motor += std::pow(tick.motor - tick.reference, 2);
    sums_.cable += std::pow(tick.joint - tick.motor, 2);
    sums_.current_rms += tick.current * tick.current;
    sums_.current_largest = std::max(sums_.current_largest, std::abs(tick.current));
    sums_.at_limit += std::abs(tick.current) >= limit_ ? 1.0 : 0.0;
    sums_.sticking += tick.velocity == 0.0 ? 1.0 : 0.0;
    ++ticks_;
    if (tick.time >= watched_) watch(tick);
  }

  DriveTracking tracking() const {
    DriveTracking t = sums_;
    const auto n = static_cast<double>(ticks_);
    for (double* square : {&t.rms, &t.trajectory, &t.motor, &t.cable, &t.current_rms}) *square = std::sqrt(*square / n);
    t.at_limit /= n;
    t.sticking /= n;
    if (torque_) t.trajectory = t.motor = t.cable = 0.0;
    if (watched_ > end_) return t;
    t.hunting.seconds = end_ - watched_;
    t.hunting.amplitude = 0.5 * (highest_ - lowest_);
    if (reversals_ >= kFewestReversals) t.hunting.frequency = 0.5 * reversals_ / t.hunting.seconds;
    return t;
  }

 private:
  static constexpr int kFewestReversals = 3;

  void watch(const TickOfDrive& tick) {
    lowest_ = std::min(lowest_, tick.motor);
    highest_ = std::max(highest_, tick.motor);
    if (tick.velocity == 0.0) return;
    if (tick.velocity * last_ < 0.0) ++reversals_;
    last_ = tick.velocity;
  }

  bool torque_;
  double limit_, end_;
  double watched_ = std::numeric_limits<double>::infinity();
  DriveTracking sums_;
  long ticks_ = 0;
  int reversals_ = 0;
  double lowest_ = std::numeric_limits<double>::infinity(), highest_ = -lowest_, last_ = 0.0;
};

void record(const TickOfDrive& tick, DriveTrack& track) {
  track.time.push_back(tick.time);
  track.told.push_back(tick.told);
  track.reference.push_back(tick.reference);
  track.joint.push_back(tick.joint);
  track.motor.push_back(tick.motor);
  track.torque.push_back(tick.torque);
  track.current.push_back(tick.current);
}

}  // namespace

CableDriveCommands readCableDriveCommands(const CsvTable& table, bool linear) {
  CableDriveCommands commands;
  commands.torque = table.offersQuantity("torque", "Nm");
  if (commands.torque == table.offersQuantity("position", "rad")) {
    throw DataError(fmt::format("{}:1: found {}, expected position_rad or torque_Nm", table.name(),
                                commands.torque ? "a position and a torque" : "no command"));
  }
  commands.over_time = readToldChannels(table, commands.torque ? kTorqueOfDrive : kPositionOfDrive, 1, linear);
  return commands;
}

CableDriveCommands readCableDriveSchedule(const YamlNode& root, double rate) {
  CableDriveCommands commands;
  commands.torque = root.at("joint").has("torque");
  commands.over_time = readToldChannels(root, commands.torque ? kTorqueOfDrive : kPositionOfDrive, 1, rate);
  return commands;
}

DriveRun playCableDrive(const CableDrive& drive, const FrictionCompensation& compensation,
                        const CableDriveCommands& commands, double end, const DrivePlay& play) {
  const double start = commands.over_time.times.front(), dt = 1.0 / drive.rate;
  const int steps = stepsPerTick(dt, play.step);
  const auto settling = static_cast<long>(std::ceil(play.settle * drive.rate));
  const auto ticks = static_cast<long>(std::floor((end - start) * drive.rate + 1e-6));
  const auto stride = static_cast<long>(std::max(1.0, std::round(drive.rate / play.row_rate)));
  std::array<double, 2> now{};
  std::size_t row = 0;
  commands.over_time.at(start, row, now);
  const double first = commands.torque ? drive.hangs_at : now[0];
  CableDriveMotion motion(drive);
  motion.reset(first);
  DriveElectronics electronics(drive, compensation, commands.torque, first);
  electronics.reset(motion.motor());
  DriveJudge judge(commands.torque, drive.control.current_limit, restBegins(commands.over_time), end);
  DriveRun run;
  double set_point = now[0], periods = 0.0;
  for (long k = -settling; k <= ticks; ++k) {
    if (k % 1000 == 0) stopIfInterrupted();
    const double since = std::max(0.0, static_cast<double>(k) * dt);
    commands.over_time.at(start + since, row, now);
    // Set-points come at their own rate, and hold until the next.
    const double arrived = std::floor(since * drive.set_point_rate + 1e-9);
    if (arrived > periods || k == 0) set_point = now[0];
    periods = std::max(periods, arrived);
    const double current = electronics.tick(set_point, motion.motor());
    if (k >= 0) {
      const TickOfDrive tick{start + since,
                             now[0],
                             electronics.reference(set_point),
                             motion.joint(),
                             motion.motor() / drive.control.ratio,
                             motion.motorVelocity(),
                             motion.cableTorque(),
                             current};
      judge.add(tick);
      if (k % stride == 0) record(tick, run.track);
    }
    for (int i = 0; i < steps; ++i) motion.step(current, now[1], dt / steps);
    if (!std::isfinite(motion.joint()) || !(std::abs(motion.motorVelocity()) < 1e9)) {
      throw NumericsError(fmt::format(
          "with {} the drive blew up at {:.3f} s with steps of {:g} s, expected smaller gains or --step-s below that",
          compensation.name, start + static_cast<double>(k) * dt, dt / steps));
    }
  }
  run.tracking = judge.tracking();
  return run;
}

}  // namespace simgap
