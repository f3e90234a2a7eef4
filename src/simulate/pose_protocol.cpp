#include "simgap/simulate/pose_protocol.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/core/position_bytes.h"

namespace simgap {
namespace {

constexpr double kMostTravelLeft = 0.5 * kDegree;  // of a joint at rest, as far as its last half second says

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

/// How far joints that are slow enough to count as resting would still travel: a slow arm creeps for degrees.
///
/// Of three looks equal times apart the two steps between them are, on a way that slows down exponentially, terms of a
/// geometric sequence, d1 and d2 = r d1; what is left of it is d2 r + d2 r^2 + ... = d2^2 / (d1 - d2) (Aitken).
class Creep {
 public:
  /// \param interval  between two looks [s]
  Creep(const BulletArm& arm, double interval, double settle)
      : arm_(arm), interval_(interval), most_(settle / interval), joints_(arm.joints()) {}

  void look(bool first) {
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      Way& way = joints_[j];
      const double step = first ? 0.0 : arm_.jointTravel(j, way.last);
      const bool goes_on = !first && arm_.jointTravel(j, way.before) > std::max(step, way.step);
      way.ratio = goes_on ? step / way.step : 0.0;  // what swings is where it will rest
      way.before = first ? arm_.jointPosition(j) : way.last;
      way.last = arm_.jointPosition(j);
      way.step = step;
    }
  }

  /// The joint with most to travel, and that way [rad].
  Worst worst() const {
    Worst worst;
    for (std::size_t j = 0; j < joints_.size(); ++j) {
      const double left = travelLeft(joints_[j]);
      if (left > worst.value) worst = {static_cast<int>(j), left};
    }
    return worst;
  }

  /// Until a joint has no more than this left [s]; 0: it does not slow down.
  double timeUntil(int joint, double left) const {
    const Way& way = joints_[static_cast<std::size_t>(joint)];
    return way.ratio < 1.0 ? interval_ * std::log(way.step * way.slowing() / left) / -std::log(way.ratio) : 0.0;
  }

 private:
  struct Way {
    JointPosition before, last;  // at the last two looks
    double step = 0.0;           // between them
    double ratio = 0.0;          // of the last step to the one before it
    double slowing() const { return ratio / (1.0 - ratio); }
  };

  /// No farther than as fast as now for another settling time: the way of what does not slow down.
  double travelLeft(const Way& way) const {
    return way.step * (way.ratio < 1.0 ? std::min(way.slowing(), most_) : most_);
  }

  const BulletArm& arm_;
  double interval_;
  double most_;
  std::vector<Way> joints_;
};

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

  const double acquired = arm.time();
  const long wanted = stepsIn(protocol.steady, protocol.arm.step);
  const long between_looks = std::max(1L, (wanted - 1) / 2);
  Creep creep(arm, static_cast<double>(between_looks) * protocol.arm.step, protocol.settle);
  long still = 0;
  Worst disturber;  // the joint that last broke the rest
  for (long i = stepsIn(protocol.settle, protocol.arm.step); i > 0; --i) {
    arm.step();
    if (!arm.isFinite()) return failed(arm, PoseStatus::kNotFinite);
    const Worst fastest = fastestJoint(arm);
    still = fastest.value < protocol.max_velocity ? still + 1 : 0;
    if (still == 0) disturber = fastest;
    if (still > 0 && (still - 1) % between_looks == 0) creep.look(still == 1);
    if (still >= wanted && creep.worst().value <= kMostTravelLeft) return atRest(arm);
  }
  if (still < wanted) return failed(arm, PoseStatus::kNotSteady, disturber);
  const Worst slowest = creep.worst();
  PoseOutcome outcome =
      failed(arm, PoseStatus::kNotSteady, {slowest.index, arm.jointSpeed(std::size_t(slowest.index))});
  const double longer = creep.timeUntil(slowest.index, kMostTravelLeft);
  if (longer > 0.0) outcome.settle_needed = arm.time() - acquired + longer;
  return outcome;
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
  pack(bytes, outcome.settle_needed);
  pack(bytes, outcome.duration);
}

void unpack(BytesReader& from, PoseOutcome& outcome) {
  unpack(from, outcome.status);
  unpack(from, outcome.joints);
  unpack(from, outcome.shafts);
  unpack(from, outcome.cord_expansion);
  unpack(from, outcome.worst);
  unpack(from, outcome.worst_value);
  unpack(from, outcome.settle_needed);
  unpack(from, outcome.duration);
}

}  // namespace simgap
