#include "simgap/simulate/pose_protocol.h"

#include <fmt/format.h>

#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/position_bytes.h"

namespace simgap {
namespace {

struct Worst {
  int index = -1;
  double value = -1.0;
};

Worst worstShaft(const BulletArm& arm) {
  Worst worst;
  for (std::size_t m = 0; m < arm.muscles(); ++m) {
    const double error = std::abs(arm.shaftError(m));
    if (error > worst.value) worst = {static_cast<int>(m), error};
  }
  return worst;
}

Worst fastestJoint(const BulletArm& arm) {
  Worst worst;
  for (std::size_t j = 0; j < arm.joints(); ++j) {
    const double speed = arm.jointSpeed(j);
    if (speed > worst.value) worst = {static_cast<int>(j), speed};
  }
  return worst;
}

long stepsIn(double duration, double step) { return std::lround(duration / step); }

/// Steps for t_a, or until the shafts have arrived and stayed. \returns false when the simulation blew up.
bool acquire(BulletArm& arm, const PoseProtocol& protocol) {
  const double step = protocol.arm.step;
  const long hold = stepsIn(protocol.early_hold, step);
  long within = 0;
  for (long i = stepsIn(protocol.acquisition, step); i > 0; --i) {
    arm.step();
    if (!arm.isFinite()) return false;
    within = worstShaft(arm).value <= protocol.max_shaft_error ? within + 1 : 0;
    if (protocol.early_acquisition && within >= hold) return true;
  }
  return true;
}

PoseOutcome failed(const BulletArm& arm, PoseStatus status, const Worst& worst = {}) {
  PoseOutcome outcome;
  outcome.status = status;
  outcome.worst = worst.index;
  outcome.worst_value = worst.value;
  outcome.duration = arm.time();
  return outcome;
}

PoseOutcome atRest(const BulletArm& arm) {
  PoseOutcome outcome;
  outcome.status = PoseStatus::kSteady;
  outcome.duration = arm.time();
  outcome.joints = arm.capturedPositions();
  for (std::size_t m = 0; m < arm.muscles(); ++m) {
    outcome.shafts.push_back(arm.shaftAngle(m));
    outcome.cord_expansion.push_back(arm.cordExpansion(m));
  }
  arm.addLineCommands(outcome.shafts);
  return outcome;
}

}  // namespace

PoseOutcome replayPose(BulletArm& arm, std::span<const double> shafts, const PoseProtocol& protocol) {
  arm.reset();
  arm.setShaftReferences(shafts);
  if (!acquire(arm, protocol)) return failed(arm, PoseStatus::kNotFinite);
  const Worst shaft = worstShaft(arm);
  if (shaft.value > protocol.max_shaft_error) return failed(arm, PoseStatus::kAcquisitionError, shaft);

  const long wanted = stepsIn(protocol.steady, protocol.arm.step);
  long still = 0;
  Worst disturber;  // the joint that last broke the rest
  for (long i = stepsIn(protocol.settle, protocol.arm.step); i > 0 && still < wanted; --i) {
    arm.step();
    if (!arm.isFinite()) return failed(arm, PoseStatus::kNotFinite);
    const Worst fastest = fastestJoint(arm);
    still = fastest.value < protocol.max_velocity ? still + 1 : 0;
    if (still == 0) disturber = fastest;
  }
  if (still < wanted) return failed(arm, PoseStatus::kNotSteady, disturber);
  return atRest(arm);
}

PoseProtocol PoseProtocol::read(const YamlNode& node) {
  PoseProtocol protocol;
  const auto read = [&node](double& value, std::string_view stem, std::string_view unit, const Range& range) {
    value = node.findQuantity(stem, unit, range).value_or(value);
  };
  read(protocol.arm.step, "step", "s", kPositive);
  read(protocol.arm.controller_rate, "controller_rate", "Hz", kPositive);
  if (const auto gain = node.find("shaft_gain_V_rad")) protocol.arm.shaft_gain = gain->number(kPositive);
  read(protocol.acquisition, "acquisition", "s", kPositive);
  read(protocol.settle, "settle", "s", kPositive);
  read(protocol.steady, "steady", "s", kPositive);
  read(protocol.max_shaft_error, "max_shaft_error", "rad", kPositive);
  read(protocol.max_velocity, "max_velocity", "rad_s", kPositive);
  read(protocol.early_hold, "early_hold", "s", kPositive);
  if (const auto early = node.find("early_acquisition")) protocol.early_acquisition = early->boolean();
  try {
    protocol.validate();
  } catch (const ConfigError& error) {
    node.fail(error.what());
  }
  return protocol;
}

void PoseProtocol::validate() const {
  arm.validate();
  if (steady > settle) {
    throw ConfigError(
        fmt::format("steady_s {} is longer than settle_s {}: no pose could ever be steady", steady, settle));
  }
}

std::string PoseProtocol::toYaml(const std::string& indent) const {
  const auto line = [&indent](std::string_view key, auto value) {
    return fmt::format("{}{}: {}\n", indent, key, value);
  };
  return line("step_s", arm.step) + line("controller_rate_Hz", arm.controller_rate) +
         line("shaft_gain_V_rad", arm.shaft_gain) + line("acquisition_s", acquisition) + line("settle_s", settle) +
         line("steady_s", steady) + line("max_shaft_error_rad", max_shaft_error) +
         line("max_velocity_rad_s", max_velocity) + line("early_acquisition", early_acquisition) +
         line("early_hold_s", early_hold);
}

std::string_view toString(PoseStatus status) {
  switch (status) {
    case PoseStatus::kSteady:
      return "steady";
    case PoseStatus::kAcquisitionError:
      return "acquisition error";
    case PoseStatus::kNotSteady:
      return "not steady";
    case PoseStatus::kNotFinite:
      return "not finite";
    case PoseStatus::kNoEquilibrium:
      return "no stable equilibrium";
    case PoseStatus::kSkipped:
      break;
  }
  return "skipped";
}

void pack(Bytes& bytes, const PoseOutcome& outcome) {
  pack(bytes, outcome.status);
  pack(bytes, outcome.joints);
  pack(bytes, outcome.shafts);
  pack(bytes, outcome.cord_expansion);
  pack(bytes, outcome.worst);
  pack(bytes, outcome.worst_value);
  pack(bytes, outcome.duration);
}

void unpack(BytesReader& from, PoseOutcome& outcome) {
  unpack(from, outcome.status);
  unpack(from, outcome.joints);
  unpack(from, outcome.shafts);
  unpack(from, outcome.cord_expansion);
  unpack(from, outcome.worst);
  unpack(from, outcome.worst_value);
  unpack(from, outcome.duration);
}

}  // namespace simgap
