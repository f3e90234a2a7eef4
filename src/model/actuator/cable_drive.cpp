#include "simgap/model/actuator/cable_drive.h"
#include "simgap/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cctype>

#include "simgap/core/error.h"
#include "simgap/model/actuator/friction_drive.h"

namespace simgap {
namespace {

constexpr Range kTickRate{1.0, 1e5, false, "a number between 1 and 1e5"};
constexpr std::size_t kMostCompensations = 8;

DriveFeedForward readFriction(const YamlNode& node, const std::function<FittedModel(const std::string& file)>& model) {
  const YamlNode file = node.at("model");
  const FittedModel fitted = model(file.text());
  try {
    return feedForward(fitted);
  } catch (const ConfigError& error) {
    file.fail(error.what());
  }
}

void readTurned(const YamlNode& node, CableDrive& drive) {
  drive.inertia = node.quantity("inertia", "kg_m2", kPositive);
  const double mass = node.findQuantity("mass", "kg", kNonNegative).value_or(0.0);
  if (mass > 0.0) drive.weight = mass * kEarthGravity * node.quantity("centre", "m", kNonNegative);
  drive.hangs_at = node.findQuantity("hangs_at", "rad").value_or(0.0);
  drive.viscous_friction = node.findQuantity("viscous_friction", "Nms", kNonNegative).value_or(0.0);
}

void readControl(const YamlNode& node, CableDrive& drive) {
  drive.rate = node.findQuantity("rate", "Hz", kTickRate).value_or(drive.rate);
  drive.set_point_rate = node.findQuantity("set_point_rate", "Hz", kPositive).value_or(drive.set_point_rate);
  if (drive.set_point_rate > drive.rate) node.fail("expected set_point_rate_Hz of at most rate_Hz");
  drive.velocity = node.quantity("velocity", "rad_s", kPositive);
  drive.acceleration = node.quantity("acceleration", "rad_s2", kPositive);
  drive.control.position_gain = node.at("position_gain_1_s").number(kNonNegative);
  drive.control.velocity_gain = node.quantity("velocity_gain", "Nms_rad", kNonNegative);
  drive.control.integrator_gain = node.quantity("integrator_gain", "Nm_rad", kNonNegative);
  constexpr double kFastestObserver = 1000.0;  // [rad/s]
  drive.observer =
      node.findQuantity("observer", "rad_s", kPositive).value_or(std::min(kFastestObserver, 0.125 * drive.rate));
  if (drive.observer > 0.5 * drive.rate) {
    node.fail(fmt::format("found observer_rad_s: {:g}, expected at most half of rate_Hz", drive.observer));
  }
  drive.control.dead_band = node.findQuantity("dead_band", "rad_s", kNonNegative).value_or(0.0);
  if (const auto direction = node.find("direction")) {
    drive.control.by_reference = direction->oneOf({"measured", "reference"}) == "reference";
  }
}

FrictionCompensation readCompensation(const YamlNode& node,
                                      const std::function<FittedModel(const std::string& file)>& model) {
  FrictionCompensation compensation{node.at("name").text(), readFriction(node, model), 1.0};
  if (!std::ranges::all_of(compensation.name,
                           [](unsigned char c) { return std::isalnum(c) || c == '-' || c == '_'; })) {
    node.at("name").fail("expected letters, digits, - and _, as it becomes the name of a column");
  }
  if (const auto share = node.find("share")) compensation.share = share->number({0.0, 10.0, false, "0 to 10"});
  return compensation;
}

}  // namespace

CableDrive readCableDrive(const YamlNode& root, const std::function<FittedModel(const std::string& file)>& model) {
  root.at("format").oneOf({"simgap/cable-drive/1"});
  CableDrive drive;
  drive.name = root.at("name").text();
  drive.control.ratio = root.at("transmission_ratio").number(kPositive);
  drive.drive = readFriction(root.at("friction"), model);
  const YamlNode motor = root.at("motor");
  drive.motor_inertia = motor.quantity("inertia", "kg_m2", kPositive);
  drive.control.current_limit = motor.quantity("current_limit", "A", kPositive);
  if (const auto counts = motor.find("encoder_counts")) {
    drive.counts = counts->number({1.0, 1e9, false, "a number between 1 and 1e9"});
  }
  const YamlNode cable = root.at("cable");
  drive.stiffness = cable.quantity("stiffness", "Nm_rad", kPositive);
  drive.damping = cable.quantity("damping", "Nms_rad", kNonNegative);
  readTurned(root.at("link"), drive);
  readControl(root.at("controller"), drive);
  drive.compensations = {{"none", drive.drive, 0.0}};
  if (const auto list = root.find("compensations")) {
    for (const YamlNode& node : list->items()) {
      FrictionCompensation compensation = readCompensation(node, model);
      if (std::ranges::find(drive.compensations, compensation.name, &FrictionCompensation::name) !=
          drive.compensations.end()) {
        node.fail(fmt::format("found a second compensation called {}, expected another name", compensation.name));
      }
      drive.compensations.push_back(std::move(compensation));
    }
    if (drive.compensations.size() > kMostCompensations + 1) {
      list->fail(fmt::format("found {} compensations, expected at most {}", drive.compensations.size() - 1,
                             kMostCompensations));
    }
  }
  root.expectAllRead();
  return drive;
}

}  // namespace simgap
