#include "simgap/measure/logs/robot_log.h"

#include <fmt/format.h>
#include <fmt/ranges.h>
#include <tbb/parallel_for.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "derived_motion.h"
#include "prepared_rows.h"
#include "row_faults.h"
#include "simgap/core/error.h"
#include "simgap/core/rotation.h"
#include "simgap/measure/logs/channel_checks.h"
#include "simgap/measure/logs/resolution.h"
#include "simgap/measure/logs/rests.h"
#include "simgap/measure/logs/stamps.h"
#include "turns.h"
#include "velocity_scale.h"

namespace simgap {
namespace {

struct ChannelName {
  std::string stem;
  const char* unit;  ///< empty: the column is called as the stem

  std::string column() const { return *unit == '\0' ? stem : fmt::format("{}_{}", stem, unit); }
};

std::vector<ChannelName> positionNames(const LoggedJoint& joint, std::size_t number) {
  const char* unit = joint.slides ? "m" : "rad";
  return {{joint.name, unit},
          {joint.name + "_position", unit},
          {joint.name + ".position", ""},
          {fmt::format("q{}", number), unit}};
}

std::vector<ChannelName> velocityNames(const LoggedJoint& joint, std::size_t number) {
  const char* unit = joint.slides ? "m_s" : "rad_s";
  return {{joint.name + "_velocity", unit}, {joint.name + ".velocity", ""}, {fmt::format("qd{}", number), unit}};
}

std::vector<ChannelName> effortNames(const LoggedJoint& joint, std::size_t number) {
  const char* unit = joint.slides ? "N" : "Nm";
  const char* kind = joint.slides ? "force" : "torque";
  return {{fmt::format("{}_{}", kind, joint.name), unit},
          {fmt::format("{}_{}", joint.name, kind), unit},
          {joint.name + ".effort", ""},
          {fmt::format("{}{}", kind, number), unit},
          {fmt::format("current_{}", joint.name), "A"},
          {joint.name + "_current", "A"},
          {fmt::format("current{}", number), "A"}};
}

std::vector<ChannelName> temperatureNames(const LoggedJoint& joint, std::size_t number) {
  return {{joint.name + "_temperature", "degC"},
          {"temperature_" + joint.name, "degC"},
          {joint.name + ".temperature", ""},
          {fmt::format("temperature{}", number), "degC"}};
}

/// The first of the names that the table has; a plain name only where it is there.
const ChannelName* firstName(const CsvTable& table, const std::vector<ChannelName>& names) {
  const auto found = std::ranges::find_if(names, [&](const ChannelName& name) {
    return *name.unit == '\0' ? table.has(name.stem) : table.offersQuantity(name.stem, name.unit);
  });
  return found == names.end() ? nullptr : &*found;
}

const ChannelName& requiredName(const CsvTable& table, const std::vector<ChannelName>& names, const char* what,
                                const LoggedJoint& joint) {
  if (const ChannelName* found = firstName(table, names)) return *found;
  std::vector<std::string> columns;
  columns.reserve(names.size());
  for (const ChannelName& name : names) columns.push_back(name.column());
  throw DataError(fmt::format("{}: found no {} of joint {}, expected one of the columns {}", table.name(), what,
                              joint.name, fmt::join(columns, ", ")));
}

/// Positions are measured, so they may pass a stop by a little.
void requireWithinLimits(const CsvTable& table, const ChannelName& name, const LoggedJoint& joint,
                         const std::vector<double>& position) {
  const double slack = joint.slides ? 0.01 : 0.05;
  for (std::size_t row = 0; row < position.size(); ++row) {
    if (position[row] >= joint.lower - slack && position[row] <= joint.upper + slack) continue;
    const bool degrees = !joint.slides && std::abs(position[row]) > 7.0 &&
                         position[row] * kDegree > joint.lower - slack && position[row] * kDegree < joint.upper + slack;
    table.fail(row, fmt::format("{}: found {:.5g} {}, expected a position within the limits of joint {}, {:.5g} to "
                                "{:.5g}{}",
                                name.column(), position[row], joint.slides ? "m" : "rad", joint.name, joint.lower,
                                joint.upper, degrees ? " (are these degrees? then the column ends in _deg)" : ""));
  }
}

/// One joint as the log of a drive of its own, with which the helpers of those work.
struct JointReader {
  ActuatorLog log;
  std::vector<double> temperature;
  FrictionData notes;
};

JointReader readJoint(CsvTable& table, const RobotLog& robot, const LoggedJoint& joint, std::size_t number) {
  JointReader reader;
  ActuatorLog& log = reader.log;
  log.file = robot.file;
  log.has_time = true;
  log.linear = joint.slides;
  log.session = robot.session;
  log.session_names = robot.session_names;
  const std::vector<ChannelName> positions = positionNames(joint, number);
  const ChannelName& position = requiredName(table, positions, "position", joint);
  log.position = table.takeQuantity(position.stem, position.unit);
  requireWithinLimits(table, position, joint, log.position);
  const std::vector<ChannelName> velocities = velocityNames(joint, number);
  if (const ChannelName* velocity = firstName(table, velocities)) {
    log.velocity = table.takeQuantity(velocity->stem, velocity->unit);
  }
  const std::vector<ChannelName> efforts = effortNames(joint, number);
  const ChannelName& effort =
      requiredName(table, efforts, joint.slides ? "force or current" : "torque or current", joint);
  log.effort = table.takeQuantity(effort.stem, effort.unit);
  log.effort_name = effort.stem;
  log.effort_unit = *effort.unit == '\0' ? (joint.slides ? "N" : "Nm") : effort.unit;
  const std::vector<ChannelName> temperatures = temperatureNames(joint, number);
  if (const ChannelName* temperature = firstName(table, temperatures)) {
    reader.temperature = table.takeQuantity(temperature->stem, temperature->unit);
  }
  return reader;
}

/// The measured velocity is that of the position, over stretches of some rows: columns of different joints, of other
/// units or signs are no log of a robot.
void requireVelocityOfPosition(const ActuatorLog& log, const std::vector<double>& time, std::span<const Block> runs,
                               const std::string& joint) {
  constexpr double kFar = 0.3, kSlip = 0.1;  // of 1
  const std::optional<VelocityScale> scale = velocityScale(time, log.position, log.velocity, runs);
  if (!scale || std::abs(scale->factor - 1.0) < kFar + 4.0 * scale->sd) return;
  throw DataError(
      fmt::format("{}: found a velocity of joint {} that is {:.3g} times the slope of its position, expected "
                  "columns of one joint, in the units that they say{}",
                  log.file, joint, scale->factor, log.linear ? "" : degreesSlip(scale->factor, kSlip)));
}

/// Beside turns, and after them and after rests until friction has built up.
void leaveOutPresliding(const ActuatorLog& log, std::span<const Block> runs, std::optional<double> known,
                        RobotJointLog& joint, MotionSign& sign) {
  // For so long around a turn the load is a polynomial of time: some periods of the smoother's bandwidth, above which
  // there is noise alone, within limits of the usual time from turn to turn.
  constexpr double kPeriods = 3.0, kLeastOfTurns = 0.125, kMostOfTurns = 0.25;
  const std::vector<std::size_t> turns = turnsOf(sign.direction, runs);
  std::vector<double> turned;
  turned.reserve(turns.size());
  for (const std::size_t row : turns) turned.push_back(log.time[row]);
  const double between = usualStep(turned);
  const double seconds = std::clamp(kPeriods / joint.bandwidth, kLeastOfTurns * between, kMostOfTurns * between);
  joint.presliding =
      known ? *known : travelOfFriction({log.time, joint.position, log.effort}, turns, runs, sign, seconds);
  if (joint.presliding == 0.0) return;  // friction that turns at once says in turning what it is at low speed
  leaveOutTurns(log.time, runs, joint.blurred(), sign);
  leaveOutFirstTravel(joint.position, log.velocity, runs, restingSpeed(log.velocity, sign.dead_band), joint.presliding,
                      sign);
}

/// The bandwidth of a motion that is smoothed less, of the usual one.
constexpr double kSharper = 1.4;

/// Whether a measured velocity's noise takes more than a trifle of the motion for rest: turns are then seen rows beside
/// where they are, and dry friction seems to build up over a travel.
bool blursTurns(std::span<const double> velocity, double dead_band_widths) {
  constexpr double kTrifle = 0.01;  // of the top speed
  return dead_band_widths * noiseLevel(velocity) > kTrifle * fastSpeed(velocity);
}

/// Velocity and acceleration, and in which rows the joint moves.
void completeJoint(JointReader& reader, std::span<const Block> runs, const std::vector<double>& time,
                   std::optional<double> presliding, RobotJointLog& joint) {
  ActuatorLog& log = reader.log;
  FrictionData& notes = reader.notes;
  const FrictionDataOptions options;
  log.time = time;
  if (blursTurns(log.velocity, options.dead_band_widths)) replaceNoisyVelocity(log, runs, notes);
  joint.measured_velocity = !log.velocity.empty();
  takeEvenTimes(log, runs, true, notes);
  putSpikesRight(log, notes);
  moveLateVelocity(log, runs, notes);
  joint.position = log.position;
  completeMotion(log, runs, std::nullopt, true, notes);
  joint.bandwidth = notes.bandwidth;
  SmoothMotion sharper = smoothMotion(log.time, joint.measured_velocity ? log.velocity : joint.position,
                                      joint.measured_velocity, runs, kSharper * notes.bandwidth);
  joint.sharper_velocity = std::move(sharper.velocity);
  joint.sharper_acceleration = std::move(sharper.acceleration);
  std::optional<double> dead_band;
  if (!joint.measured_velocity) {
    constexpr double kRounding = 1e-9;  // [rad/s] what smoothing makes of a joint that is held
    dead_band = std::max(kRounding, derivedDeadBand(log, runs, notes.bandwidth, options.dead_band_widths));
  }
  MotionSign sign = holdSign(log.velocity, options.dead_band_widths, dead_band);
  joint.dead_band = sign.dead_band;
  FrictionData rests;  // its sentence is that of one drive; here the rows are counted per joint
  // Velocity is smoothed and acceleration worked out even where velocity was measured: both are blurred beside rests.
  leaveOutRests(log, joint.blurred(), true, options, sign, rests);
  leaveOutPresliding(log, runs, presliding, joint, sign);
  for (const ChannelSpikes& spikes : notes.spikes) {
    for (const std::size_t row : spikes.rows) sign.keep[row] = false;
  }
  joint.resting = static_cast<std::size_t>(std::ranges::count(sign.keep, false));
  if (joint.measured_velocity) log.velocity = smoothRuns(log.time, log.velocity, runs, notes.bandwidth);
  joint.velocity = std::move(log.velocity);
  joint.acceleration = std::move(log.acceleration);
  joint.effort = std::move(log.effort);
  joint.temperature = std::move(reader.temperature);
  joint.direction = std::move(sign.direction);
  joint.moves = std::move(sign.keep);
}

/// A smoother knows one side only within half a period of its bandwidth at the ends of a run.
void markEnds(std::span<const Block> runs, RobotLog& robot) {
  double margin = 0.0;
  for (const RobotJointLog& joint : robot.joints) margin = std::max(margin, joint.blurred());
  robot.usable.assign(robot.rows(), true);
  for (const Block& run : runs) {
    const double begin = robot.time[run.begin] + margin, end = robot.time[run.end - 1] - margin;
    for (std::size_t i = run.begin; i < run.end; ++i) robot.usable[i] = robot.time[i] >= begin && robot.time[i] <= end;
  }
}

/// A joint that moves takes effort; a sensor that says nothing else is none.
void requireEffort(const ActuatorLog& joint, const std::string& file, const std::string& name) {
  if (!isConstant(joint.effort) || isConstant(joint.position)) return;
  throw DataError(
      fmt::format("{}: the effort of joint {} is {:.4g} in every row while it moves, expected what moved it", file,
                  name, joint.effort.front()));
}

}  // namespace

RobotLog sharperMotion(RobotLog log) {
  for (RobotJointLog& joint : log.joints) {
    joint.velocity = std::move(joint.sharper_velocity);
    joint.acceleration = std::move(joint.sharper_acceleration);
  }
  return log;
}

RobotLog readRobotLog(CsvTable table, std::span<const LoggedJoint> joints) {
  RobotLog robot;
  robot.file = table.name();
  robot.time = table.quantity("time", "s");
  robot.session = readSessions(table, robot.session_names);
  requireRisingTime(table, robot.time, robot.session);
  std::vector<JointReader> readers;
  for (std::size_t j = 0; j < joints.size(); ++j) readers.push_back(readJoint(table, robot, joints[j], j + 1));
  const bool current = readers.front().log.effort_unit == "A";
  for (std::size_t j = 0; j < joints.size(); ++j) {
    if ((readers[j].log.effort_unit == "A") == current) continue;
    throw DataError(fmt::format("{}: found a {} of joint {} and a {} of joint {}, expected one kind for all joints",
                                robot.file, current ? "current" : "torque", joints[0].name,
                                current ? "torque" : "current", joints[j].name));
  }
  const std::vector<Block> runs = splitRuns(robot.time, robot.session);
  for (std::size_t j = 0; j < joints.size(); ++j) {
    requireEffort(readers[j].log, robot.file, joints[j].name);
    if (!readers[j].log.velocity.empty()) requireVelocityOfPosition(readers[j].log, robot.time, runs, joints[j].name);
  }
  robot.joints.resize(joints.size());
  tbb::parallel_for(std::size_t{0}, joints.size(), [&](std::size_t j) {
    robot.joints[j].name = joints[j].name;
    robot.joints[j].effort_unit = readers[j].log.effort_unit;
    robot.joints[j].slides = joints[j].slides;
    completeJoint(readers[j], runs, robot.time, joints[j].presliding, robot.joints[j]);
  });
  for (std::size_t j = 0; j < joints.size(); ++j) {
    for (const std::string& sentence : readers[j].notes.warnings) {
      robot.warnings.push_back(fmt::format("joint {}: {}", joints[j].name, sentence));
    }
  }
  markEnds(runs, robot);
  std::size_t most = 0;
  for (const RobotJointLog& joint : robot.joints) most = std::max(most, joint.resting);
  if (most > 0) {
    robot.warnings.push_back(
        fmt::format("joints stand still, or turn back, in up to {} of {} rows: there they are left out, because a held "
                    "joint's effort may lie anywhere within its static friction",
                    most, robot.rows()));
  }
  robot.blocks = splitBlocks(robot.time, robot.session, blockSecondsOf(robot.time, robot.session));
  return robot;
}

}  // namespace simgap
