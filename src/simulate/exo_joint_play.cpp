#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "schedule_line.h"
#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/simulate/exo_joint_motion.h"

namespace simgap {
namespace {

const std::vector<CommandChannel> kTorqueChannels = {{"torque", "Nm"}, {"external_torque", "Nm"}};
const std::vector<CommandChannel> kPressureChannels = {
    {"pressure_flexor", "Pa"}, {"pressure_extensor", "Pa"}, {"current", "A"}, {"external_torque", "Nm"}};
/// May be missing: 0 then.
bool optionalChannel(const CommandChannel& channel) {
  return channel.stem == "current" || channel.stem == "external_torque";
}

/// Of valves: below 0 nothing is let in.
void refuseSuction(const ExoJointCommands& commands, const auto& fail) {
  if (commands.torque) return;
  for (Eigen::Index row = 0; row < commands.over_time.values.cols(); ++row) {
    for (const Eigen::Index channel : {0, 1}) {
      const double pressure = commands.over_time.values(channel, row);
      if (pressure < 0.0) fail(row, fmt::format("found a pressure of {:g} Pa, expected none below 0", pressure));
    }
  }
}

/// The controller of a joint: what it sends at a tick.
class ExoController {
 public:
  ExoController(const ExoJoint& joint, const ExoJointCommands& commands, const ExoJointPlay& play)
      : joint_(joint),
        commands_(commands),
        split_(play.tendons ? joint.muscles : joint.muscles.withoutTendons(),
               {joint.supply, play.motor ? joint.motorLimit() : 0.0, play.motor && joint.motor ? joint.crossover : 0.0,
                joint.co_contraction}) {}

  ExoJointMotion::Inputs at(double time, double angle, double muscles) {
    std::array<double, 4> values{};
    commands_.over_time.at(time, row_, std::span(values).first(commands_.torque ? 2 : 4));
    if (!commands_.torque) return {values[0], values[1], values[2], values[3]};
    shares_ = split_.update(values[0], angle, muscles, 1.0 / joint_.rate);
    desired_ = values[0];
    const double current = joint_.motor ? shares_.motor / joint_.motor->torquePerAmpere() : 0.0;
    return {shares_.flexor_pressure, shares_.extensor_pressure, current, values[1]};
  }
  double desired() const { return desired_; }
  double missing() const { return shares_.missing; }

 private:
  const ExoJoint& joint_;
  const ExoJointCommands& commands_;
  TorqueSplit split_;
  TorqueShares shares_;
  double desired_ = 0.0;
  std::size_t row_ = 0;
};

void recordTick(const ExoJoint& joint, const ExoJointMotion& motion, const ExoController& controller, double time,
                double current, bool torque, ExoJointTrack& track) {
  const double flexor = motion.state()[ExoJointMotion::kFlexorPressure];
  const double extensor = motion.state()[ExoJointMotion::kExtensorPressure];
  track.time.push_back(time);
  track.angle.push_back(motion.angle());
  track.velocity.push_back(motion.velocity());
  track.flexor_pressure.push_back(flexor);
  track.extensor_pressure.push_back(extensor);
  track.flexor_force.push_back(motion.flexorForce());
  track.extensor_force.push_back(motion.extensorForce());
  track.muscles.push_back(motion.muscleTorque());
  track.motor.push_back(motion.motorTorque(current));
  track.stiffness.push_back(joint.muscles.stiffness(flexor, extensor, motion.angle()));
  if (!torque) return;
  track.desired.push_back(controller.desired());
  track.missing.push_back(controller.missing());
}

}  // namespace

ExoJointCommands readExoJointCommands(const CsvTable& table, bool linear) {
  ExoJointCommands commands;
  commands.torque = table.offersQuantity("torque", "Nm");
  if (!commands.torque && !table.offersQuantity("pressure_flexor", "Pa")) {
    throw DataError(table.name() +
                    ":1: found no command, expected torque_Nm, or pressure_flexor_Pa and "
                    "pressure_extensor_Pa");
  }
  PoseLayout layout;
  std::vector<Eigen::Index> places;
  const std::vector<CommandChannel>& channels = commands.torque ? kTorqueChannels : kPressureChannels;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (optionalChannel(channels[i]) && !table.offersQuantity(channels[i].stem, channels[i].unit)) continue;
    layout.lines.push_back(channels[i]);
    places.push_back(static_cast<Eigen::Index>(i));
  }
  commands.over_time = readCommands(table, layout, linear);
  Eigen::MatrixXd values = Eigen::MatrixXd::Zero(std::ssize(channels), commands.over_time.values.cols());
  values(places, Eigen::all) = commands.over_time.values;
  commands.over_time.values = std::move(values);
  refuseSuction(commands, [&](Eigen::Index row, const std::string& sentence) {
    table.fail(static_cast<std::size_t>(row), sentence);
  });
  return commands;
}

ExoJointCommands readExoJointSchedule(const YamlNode& root, double rate) {
  root.at("format").oneOf({"simgap/schedule/1"});
  const YamlNode node = root.at("joint");
  ExoJointCommands commands;
  commands.torque = node.has("torque");
  const std::vector<CommandChannel>& channels = commands.torque ? kTorqueChannels : kPressureChannels;
  std::vector<ScheduleLine> lines(channels.size());
  double end = 0.0;
  for (std::size_t i = 0; i < channels.size(); ++i) {
    if (optionalChannel(channels[i]) && !node.has(channels[i].stem)) continue;
    for (const YamlNode& item : node.at(channels[i].stem).at("segments").items()) {
      lines[i].segments.push_back(readSegment(item, lines[i], channels[i].unit));
    }
    end = std::max(end, lines[i].end());
  }
  const double duration = root.findQuantity("duration", "s", kPositive).value_or(end);
  root.expectAllRead();
  const std::size_t rows = scheduleRows(root, duration, rate);
  commands.over_time.values.resize(std::ssize(channels), static_cast<Eigen::Index>(rows));
  for (std::size_t row = 0; row < rows; ++row) {
    const double time = static_cast<double>(row) / rate;
    commands.over_time.times.push_back(time);
    for (std::size_t i = 0; i < lines.size(); ++i) {
      commands.over_time.values(static_cast<Eigen::Index>(i), static_cast<Eigen::Index>(row)) = lines[i].at(time);
    }
  }
  refuseSuction(commands, [&](Eigen::Index, const std::string& sentence) { node.fail(sentence); });
  return commands;
}

ExoJointTrack playExoJoint(const ExoJoint& joint, const ExoJointCommands& commands, double end,
                           const ExoJointPlay& play) {
  const double start = commands.over_time.times.front(), tick = 1.0 / joint.rate;
  const auto steps = static_cast<int>(std::ceil(tick / play.step - 1e-9));
  const auto settling = static_cast<long>(std::ceil(play.settle * joint.rate));
  const auto ticks = static_cast<long>(std::floor((end - start) * joint.rate + 1e-6));
  ExoController controller(joint, commands, play);
  ExoJointMotion motion(joint);
  const double middle = std::clamp(joint.link.hangs_at, joint.link.lower, joint.link.upper);
  motion.reset(middle, controller.at(start, middle, 0.0));
  ExoJointTrack track;
  for (long k = -settling; k <= ticks; ++k) {
    if (k % 1000 == 0) stopIfInterrupted();
    const double time = start + static_cast<double>(k) * tick;
    const ExoJointMotion::Inputs inputs = controller.at(std::max(start, time), motion.angle(), motion.muscleTorque());
    if (k >= 0) recordTick(joint, motion, controller, time, inputs.current, commands.torque, track);
    for (int i = 0; i < steps; ++i) motion.step(inputs, tick / steps);
    if (!motion.state().allFinite()) {
      throw NumericsError(fmt::format(
          "the joint blew up at {:.3f} s with steps of {:g} s, expected --step-s below that", time, tick / steps));
    }
  }
  return track;
}

}  // namespace simgap
