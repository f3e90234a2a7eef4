#include "simgap/model/actuator/exo_joint.h"
#include "simgap/core/units.h"

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "simgap/core/text.h"

namespace simgap {
namespace {

constexpr Range kBraidAngle{0.0, 0.955, true, "an angle between 0 and 54.7 deg, at which no muscle contracts"};
constexpr Range kContractionRange{-0.5, 0.5, false, "a number between -0.5 and 0.5"};
constexpr Range kPressureRange{0.0, 1e7, true, "a number > 0, at most 100 bar"};
constexpr Range kRateRange{1.0, 1e5, false, "a number between 1 and 1e5"};

/// a, b, c as they stand there, of the geometry, or of a fit; k_N beside the first two.
Pam readExoLaw(const YamlNode& node, const std::function<FittedModel(const std::string& file)>& model,
               ExoJoint& joint) {
  if (const auto file = node.find("model")) {
    const FittedModel fitted = model(file->text());
    if (!fitted.extensions.empty()) {
      file->fail("found causes that were added to the muscle's law, expected what fit-pam leaves without --model");
    }
    joint.lowest_fitted = std::max(joint.lowest_fitted, parseNumber(fitted.setting("contraction_min")).value_or(-1.0));
    joint.highest_fitted = std::min(joint.highest_fitted, parseNumber(fitted.setting("contraction_max")).value_or(1.0));
    const double tendon = fitted.valueOr("k", kInfinity);
    if (!(tendon > 0.0)) file->fail(fmt::format("found k = {:g} N, expected a number > 0", tendon));
    return {fitted.value("a"), fitted.value("b"), fitted.value("c"), tendon};
  }
  Pam muscle;
  if (node.hasQuantity("diameter", "m")) {
    muscle = muscleOf(node.quantity("diameter", "m", kPositive), node.quantity("braid_angle", "rad", kBraidAngle));
  } else {
    muscle.a = node.quantity("a", "m2", kPositive);
    muscle.b = node.quantity("b", "m2");
    muscle.c = node.quantity("c", "m2", kPositive);
  }
  muscle.k = node.findQuantity("k", "N", kPositive).value_or(kInfinity);
  return muscle;
}

Pam readExoMuscle(const YamlNode& node, const std::function<FittedModel(const std::string& file)>& model,
                  ExoJoint& joint) {
  Pam muscle = readExoLaw(node, model, joint);
  if (!(muscle.a > 0.0 && muscle.b < 0.0 && muscle.c > 0.0 && muscle.b * muscle.b > 4.0 * muscle.a * muscle.c)) {
    node.fail(
        fmt::format("found a = {:g}, b = {:g}, c = {:g} m2, a force that does not fall to 0 as the muscle contracts; "
                    "expected a > 0, "
                    "b < 0, c > 0 and b^2 > 4 a c",
                    muscle.a, muscle.b, muscle.c));
  }
  muscle.lowest = -kInfinity;
  muscle.highest = muscle.slack();
  return muscle;
}

ExoMotor readExoMotor(const YamlNode& node) {
  ExoMotor motor;
  motor.torque_constant = node.quantity("torque_constant", "Nm_A", kPositive);
  motor.ratio = node.at("ratio").number(kPositive);
  if (const auto efficiency = node.find("efficiency")) motor.efficiency = efficiency->number(kEfficiency);
  motor.current_limit = node.quantity("current_limit", "A", kPositive);
  motor.inertia = node.findQuantity("inertia", "kg_m2", kNonNegative).value_or(0.0);
  motor.coulomb_friction = node.findQuantity("coulomb_friction", "Nm", kNonNegative).value_or(0.0);
  motor.viscous_friction = node.findQuantity("viscous_friction", "Nms", kNonNegative).value_or(0.0);
  return motor;
}

ExoLink readExoLink(const YamlNode& node) {
  ExoLink link;
  link.inertia = node.quantity("inertia", "kg_m2", kPositive);
  const double mass = node.findQuantity("mass", "kg", kNonNegative).value_or(0.0);
  if (mass > 0.0) link.weight = mass * kEarthGravity * node.quantity("centre", "m", kNonNegative);
  link.hangs_at = node.findQuantity("hangs_at", "rad").value_or(0.0);
  link.coulomb_friction = node.findQuantity("coulomb_friction", "Nm", kNonNegative).value_or(0.0);
  link.viscous_friction = node.findQuantity("viscous_friction", "Nms", kNonNegative).value_or(0.0);
  link.lower = node.quantity("lower_limit", "rad");
  link.upper = node.quantity("upper_limit", "rad");
  if (!(link.lower < link.upper)) node.fail("expected lower_limit_rad below upper_limit_rad");
  return link;
}

/// \param supply  [Pa]
CoContraction readCoContraction(const YamlNode& node, double supply) {
  using Kind = CoContraction::Kind;
  const int given = int(node.hasQuantity("co_contraction", "N")) + int(node.hasQuantity("stiffness", "Nm_rad")) +
                    int(node.hasQuantity("extensor_pressure", "Pa"));
  if (given > 1) node.fail("found two of co_contraction_N, stiffness_Nm_rad and extensor_pressure_Pa, expected one");
  if (const auto stiffness = node.findQuantity("stiffness", "Nm_rad", kPositive)) return {Kind::kStiffness, *stiffness};
  if (const auto pressure = node.findQuantity("extensor_pressure", "Pa", kPressureRange)) {
    if (*pressure > supply) {
      node.fail(fmt::format("found an extensor_pressure of {:.3g} Pa, expected at most the supply's {:.3g} Pa",
                            *pressure, supply));
    }
    return {Kind::kExtensorPressure, *pressure};
  }
  return {Kind::kForce, node.findQuantity("co_contraction", "N", kNonNegative).value_or(0.0)};
}

ExoSwitch readExoSwitch(const YamlNode& node) {
  ExoSwitch by_switch{node.quantity("up", "Nm"), node.quantity("down", "Nm"), {}};
  if (!(by_switch.down < by_switch.up)) node.fail("expected down_Nm below up_Nm");
  by_switch.rise_time = node.findQuantity("rise_time", "s", kPositive).value_or(ExoSwitch().rise_time);
  return by_switch;
}

/// The parabola turns upwards again beyond its vertex, and says nothing of a muscle stretched by half.
void requireWithinLaw(const YamlNode& node, const ExoJoint& joint) {
  constexpr double kMostStretched = -0.3;
  const AntagonistJoint& m = joint.muscles;
  const auto check = [&](const char* name, const Pam& muscle, double one, double other) {
    const double low = std::min(one, other), high = std::max(one, other), vertex = -muscle.b / (2.0 * muscle.a);
    if (low >= kMostStretched && high <= vertex) return;
    node.fail(
        fmt::format("at the joint's limits the {} contracts by {:.3f} … {:.3f}, expected {:g} … {:.3f}, where its "
                    "law holds",
                    name, low, high, kMostStretched, vertex));
  };
  check("flexor", m.flexor, m.flexorContraction(joint.link.lower), m.flexorContraction(joint.link.upper));
  check("extensor", m.extensor, m.extensorContraction(joint.link.lower), m.extensorContraction(joint.link.upper));
}

}  // namespace

Pam muscleOf(double diameter, double braid_angle) {
  const double area = std::numbers::pi * diameter * diameter / 4.0;
  const double tan2 = std::pow(std::tan(braid_angle), 2), sin2 = std::pow(std::sin(braid_angle), 2);
  return {3.0 * area / tan2, -6.0 * area / tan2, area * (3.0 / tan2 - 1.0 / sin2)};
}

AntagonistJoint readPulley(const YamlNode& root) {
  root.at("format").oneOf({"simgap/exo-joint/1"});
  AntagonistJoint joint;
  joint.radius = root.quantity("pulley_radius", "m", kPositive);
  joint.length = root.quantity("muscle_length", "m", kPositive);
  joint.rest_flexor = root.at("flexor").at("contraction_at_zero").number(kContractionRange);
  joint.rest_extensor = root.at("extensor").at("contraction_at_zero").number(kContractionRange);
  return joint;
}

ExoJoint readExoJoint(const YamlNode& root, const std::function<FittedModel(const std::string& file)>& model) {
  ExoJoint joint;
  joint.muscles = readPulley(root);
  joint.name = root.at("name").text();
  joint.muscles.flexor = readExoMuscle(root.at("flexor"), model, joint);
  joint.muscles.extensor = readExoMuscle(root.at("extensor"), model, joint);
  if (const auto braid = root.find("hysteresis")) {
    joint.hysteresis = braid->quantity("h", "m2", kNonNegative);
    if (const auto slip = braid->find("slip"))
      joint.slip = slip->number({1e-5, 0.5, false, "a number from 1e-5 to 0.5"});
  }
  const YamlNode valves = root.at("valves");
  joint.supply = valves.quantity("supply", "Pa", kPressureRange);
  joint.valve_time = valves.quantity("time_constant", "s", kPositive);
  if (const auto motor = root.find("motor")) joint.motor = readExoMotor(*motor);
  joint.link = readExoLink(root.at("link"));
  if (const auto controller = root.find("controller")) {
    joint.rate = controller->findQuantity("rate", "Hz", kRateRange).value_or(joint.rate);
    joint.crossover = controller->findQuantity("crossover", "Hz", kNonNegative).value_or(0.0);
    joint.co_contraction = readCoContraction(*controller, joint.supply);
  }
  if (const auto node = root.find("switch")) joint.by_switch = readExoSwitch(*node);
  root.expectAllRead();
  requireWithinLaw(root.at("link"), joint);
  return joint;
}

}  // namespace simgap
