#include <fmt/format.h>

#include <algorithm>
#include <array>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/interrupt.h"
#include "simgap/core/units.h"
#include "simgap/simulate/exo_joint_motion.h"
#include "simgap/simulate/tick_steps.h"
#include "told_channels.h"

namespace simgap {
namespace {

const std::vector<CommandChannel> kTorqueChannels = {{"torque", "Nm"}, {"external_torque", "Nm"}};
const std::vector<CommandChannel> kPressureChannels = {
    {"pressure_flexor", "Pa"}, {"pressure_extensor", "Pa"}, {"current", "A"}, {"external_torque", "Nm"}};
/// The first of them; the others may be missing.
constexpr std::size_t kRequiredTorques = 1, kRequiredPressures = 2;

/// A controller may ask for more than valves and motor give; who tells them pressures and a current himself would read
/// the motion of others.
void refuseImpossible(const ExoJoint& joint, const ExoJointCommands& commands, const auto& fail) {
  if (commands.torque) return;
  constexpr double kConverted = 1.0 + 1e-9;  // of a unit that was converted
  const double limit = joint.motor ? joint.motor->current_limit : 0.0;
  for (Eigen::Index row = 0; row < commands.over_time.values.cols(); ++row) {
    for (const Eigen::Index channel : {0, 1}) {
      const double pressure = commands.over_time.values(channel, row);
      if (pressure >= 0.0 && pressure <= kConverted * joint.supply) continue;
      fail(row, fmt::format("found a {} of {:g} Pa, expected {}", kPressureChannels[channel].stem, pressure,
                            pressure < 0.0 ? "none below 0" : fmt::format("at most the supply's {:g}", joint.supply)));
    }
    const double current = commands.over_time.values(2, row);
    if (std::abs(current) <= kConverted * limit) continue;
    fail(row, fmt::format("found a current of {:g} A, expected {}", current,
                          joint.motor ? fmt::format("at most the limit of {:g} either way", limit)
                                      : "none of a joint without a motor"));
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

ExoJointCommands readExoJointCommands(const ExoJoint& joint, const CsvTable& table, bool linear) {
  ExoJointCommands commands;
  commands.torque = table.offersQuantity("torque", "Nm");
  if (!commands.torque && !table.offersQuantity("pressure_flexor", "Pa")) {
    throw DataError(table.name() +
                    ":1: found no command, expected torque_Nm, or pressure_flexor_Pa and "
                    "pressure_extensor_Pa");
  }
  for (const CommandChannel& c : kPressureChannels) {
    if (!commands.torque || !table.offersQuantity(c.stem, c.unit)) continue;
    throw DataError(fmt::format("{}:1: found torque_Nm and {}, expected a torque, or pressures and a current",
                                table.name(), quantityName(c.stem, c.unit)));
  }
  commands.over_time = commands.torque ? readToldChannels(table, kTorqueChannels, kRequiredTorques, linear)
                                       : readToldChannels(table, kPressureChannels, kRequiredPressures, linear);
  refuseImpossible(joint, commands, [&](Eigen::Index row, const std::string& sentence) {
    table.fail(static_cast<std::size_t>(row), sentence);
  });
  return commands;
}

ExoJointCommands switchedTorques(const ExoJoint& joint, const LegSwitch& told, double end) {
  if (!joint.by_switch) {
    throw ConfigError("found a switch and a joint without one, expected switch: {up_Nm, down_Nm} in the joint's file");
  }
  const ExoSwitch& by_switch = *joint.by_switch;
  const double start = told.times.front(), kept = std::exp(-1.0 / (joint.rate * by_switch.rise_time));
  const auto ticks = static_cast<Eigen::Index>(std::floor((end - start) * joint.rate + 1e-6)) + 1;
  ExoJointCommands commands{true, {{}, {}, Eigen::MatrixXd::Zero(std::ssize(kTorqueChannels), ticks), false}, true};
  std::size_t row = 0;
  double torque = told.up.front() ? by_switch.up : by_switch.down;
  for (Eigen::Index k = 0; k < ticks; ++k) {
    const double time = start + static_cast<double>(k) / joint.rate;
    while (row + 1 < told.times.size() && told.times[row + 1] <= time) ++row;
    const double asked = told.up[row] ? by_switch.up : by_switch.down;
    torque = asked + kept * (torque - asked);
    commands.over_time.times.push_back(time);
    commands.over_time.values(0, k) = torque;
  }
  return commands;
}

ExoJointCommands readExoJointSchedule(const ExoJoint& joint, const YamlNode& root) {
  const YamlNode node = root.at("joint");
  ExoJointCommands commands;
  commands.torque = node.has("torque");
  commands.over_time = commands.torque ? readToldChannels(root, kTorqueChannels, kRequiredTorques, joint.rate)
                                       : readToldChannels(root, kPressureChannels, kRequiredPressures, joint.rate);
  refuseImpossible(joint, commands, [&](Eigen::Index row, const std::string& sentence) {
    node.fail(fmt::format("at {:g} s {}", commands.over_time.times[row], sentence));
  });
  return commands;
}

ExoJointTrack playExoJoint(const ExoJoint& joint, const ExoJointCommands& commands, double end,
                           const ExoJointPlay& play) {
  const double start = commands.over_time.times.front(), tick = 1.0 / joint.rate;
  const int steps = stepsPerTick(tick, play.step);
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
