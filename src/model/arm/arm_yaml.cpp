#include "simgap/model/arm/arm_yaml.h"

#include <fmt/format.h>

#include <set>

#include "arm_yaml_parts.h"
#include "simgap/model/arm/arm_effect.h"

namespace simgap {
namespace {

using namespace arm_yaml;

/// A value given in the node, or the default; without a default it is required.
double readOr(const YamlNode& node, std::string_view stem, std::string_view unit, const Range& range,
              const double* fallback) {
  if (!fallback) return node.quantity(stem, unit, range);
  return node.findQuantity(stem, unit, range).value_or(*fallback);
}

constexpr Range kInductance{0.0, kInfinity, true, "a number > 0 (1e-6 H stands for a winding without a lag)"};

Motor readMotor(const YamlNode& node, const Motor* fallback) {
  const auto read = [&](std::string_view stem, std::string_view unit, const Range& range, double Motor::*member) {
    return readOr(node, stem, unit, range, fallback ? &(fallback->*member) : nullptr);
  };
  Motor motor;
  motor.resistance = read("resistance", "ohm", kPositive, &Motor::resistance);
  motor.inductance = read("inductance", "H", kInductance, &Motor::inductance);
  motor.back_emf_constant = read("back_emf_constant", "Vs", kPositive, &Motor::back_emf_constant);
  motor.torque_constant = read("torque_constant", "Nm_A", kPositive, &Motor::torque_constant);
  motor.inertia = read("inertia", "kg_m2", kPositive, &Motor::inertia);
  motor.viscous_friction = read("viscous_friction", "Nms", kNonNegative, &Motor::viscous_friction);
  motor.coulomb_friction = read("coulomb_friction", "Nm", kNonNegative, &Motor::coulomb_friction);
  motor.supply_voltage = read("supply_voltage", "V", kPositive, &Motor::supply_voltage);
  return motor;
}

Gearbox readGearbox(const YamlNode& node, const Gearbox* fallback) {
  const auto plain = [&](std::string_view key, const Range& range, double Gearbox::*member) {
    const auto value = fallback ? node.find(key) : node.at(key);
    return value ? value->number(range) : fallback->*member;
  };
  const auto read = [&](std::string_view stem, std::string_view unit, const Range& range, double Gearbox::*member) {
    return readOr(node, stem, unit, range, fallback ? &(fallback->*member) : nullptr);
  };
  Gearbox gearbox;
  gearbox.ratio = plain("ratio", kPositive, &Gearbox::ratio);
  gearbox.efficiency = plain("efficiency", kEfficiency, &Gearbox::efficiency);
  gearbox.inertia = read("inertia", "kg_m2", kNonNegative, &Gearbox::inertia);
  gearbox.viscous_friction = read("viscous_friction", "Nms", kNonNegative, &Gearbox::viscous_friction);
  gearbox.coulomb_friction = read("coulomb_friction", "Nm", kNonNegative, &Gearbox::coulomb_friction);
  return gearbox;
}

Muscle readMuscle(const YamlNode& node, const ArmModel& model, const YamlNode& root, const Places& places,
                  std::set<std::string>& names, bool second_version) {
  Muscle muscle;
  muscle.name = readName(node, names);
  static_cast<TendonPath&>(muscle) = readPath(node.at("attachments"), model, places, second_version);
  if (const auto path = node.find("path")) path->oneOf({"straight"});
  if (const auto line = second_version ? node.find("line") : std::nullopt) {
    muscle.rope = line->oneOf({"straight", "rope"}) == "rope";
    if (muscle.rope && !muscle.straight()) line->fail("found a rope over points or surfaces, expected two attachments");
  }
  muscle.kite_line_length = node.quantity("kite_line_length", "m");
  const YamlNode cord = node.at("shock_cord");
  muscle.shock_cord.rest_length = cord.quantity("rest_length", "m", kPositive);
  muscle.shock_cord.stiffness = cord.quantity("stiffness", "N_m", kPositive);
  muscle.shock_cord.damping = cord.quantity("damping", "Ns_m", kNonNegative);
  muscle.spindle_radius = node.quantity("spindle_radius", "m", kPositive);
  if (const auto potentiometer = node.find("potentiometer")) {
    muscle.potentiometer_initial = potentiometer->quantity("initial", "rad");
  }
  // Without defaults in the file every muscle must state its own.
  const auto motor = node.find("motor");
  const auto gearbox = node.find("gearbox");
  if (!motor && !root.has("motor_defaults")) node.fail("'motor' is missing, and the file has no 'motor_defaults'");
  if (!gearbox && !root.has("gearbox_defaults"))
    node.fail("'gearbox' is missing, and the file has no 'gearbox_defaults'");
  muscle.motor =
      motor ? readMotor(*motor, root.has("motor_defaults") ? &model.motor_defaults : nullptr) : model.motor_defaults;
  muscle.gearbox = gearbox ? readGearbox(*gearbox, root.has("gearbox_defaults") ? &model.gearbox_defaults : nullptr)
                           : model.gearbox_defaults;
  return muscle;
}

}  // namespace

ArmModel readArm(const YamlNode& root, const MeshReader& mesh) {
  ArmModel model;
  const bool second_version = root.at("format").oneOf({"simgap/arm/1", "simgap/arm/2"}) == "simgap/arm/2";
  model.name = root.at("name").text();
  model.gravity = root.vectorQuantity("gravity", "m_s2");
  const Places places = readBodiesAndJoints(root, model, second_version, mesh);
  if (const auto node = root.find("motor_defaults")) model.motor_defaults = readMotor(*node, nullptr);
  if (const auto node = root.find("gearbox_defaults")) model.gearbox_defaults = readGearbox(*node, nullptr);
  std::set<std::string> names;
  if (const auto muscles = second_version ? root.find("muscles") : root.at("muscles")) {
    for (const YamlNode& muscle : muscles->items()) {
      model.muscles.push_back(readMuscle(muscle, model, root, places, names, second_version));
    }
  }
  if (const auto tendons = second_version ? root.find("tendons") : std::nullopt) {
    for (const YamlNode& tendon : tendons->items()) {
      model.tendons.push_back(readTendon(tendon, model, places, names));
    }
  }
  if (const auto extensions = root.find("extensions")) {
    model.extensions = readExtensions(*extensions);
    const std::vector<YamlNode> entries = extensions->items();
    for (std::size_t i = 0; i < entries.size(); ++i) {
      const std::string wrong = checkExtension(model.extensions[i], model);
      if (wrong.empty()) continue;
      (findArmEffect(model.extensions[i].effect) ? entries[i] : entries[i].at("effect")).fail(wrong);
    }
  }
  root.expectAllRead();
  return model;
}

}  // namespace simgap
