#include "simgap/model/arm/arm_yaml.h"

#include <fmt/format.h>
#include <fmt/ranges.h>

#include <numbers>
#include <set>

#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/arm_effect.h"

namespace simgap {
namespace {

std::string readName(const YamlNode& node, std::set<std::string>& taken) {
  const YamlNode at = node.at("name");
  std::string name = at.text();
  if (name.empty() || name.find_first_of(".*,") != std::string::npos) {
    at.fail(fmt::format("found '{}', expected a name without '.', '*' or ','", name));
  }
  if (!taken.insert(name).second) at.fail(fmt::format("the name '{}' is taken", name));
  return name;
}

int readBody(const YamlNode& node, const std::vector<Body>& bodies) {
  const std::string name = node.text();
  for (std::size_t i = 0; i < bodies.size(); ++i) {
    if (bodies[i].name == name) return static_cast<int>(i);
  }
  node.fail(fmt::format("found '{}', expected the name of a body", name));
}

Eigen::Vector3d readAxis(const YamlNode& node) {
  const Eigen::Vector3d axis = node.vector3();
  if (axis.norm() < 1e-9) node.fail("found a zero vector, expected an axis");
  // What is of unit length but for rounding stays as it is: a written model reads back bit by bit.
  return std::abs(axis.norm() - 1.0) < 1e-12 ? axis : axis.normalized();
}

double volume(const Part& part) {
  switch (part.shape) {
    case Part::Shape::kSphere:
      return 4.0 / 3.0 * std::numbers::pi * part.radius * part.radius * part.radius;
    case Part::Shape::kBox:
      return part.size.prod();
    case Part::Shape::kCylinder:
      break;
  }
  return std::numbers::pi * part.radius * part.radius * part.length;
}

Part readPart(const YamlNode& node, std::set<std::string>& names) {
  Part part;
  part.name = readName(node, names);
  const std::string shape = node.at("shape").oneOf({"sphere", "cylinder", "box"});
  if (shape == "box") {
    part.shape = Part::Shape::kBox;
    part.size = node.vectorQuantity("size", "m");
    if ((part.size.array() <= 0.0).any()) node.fail("size_m: expected three lengths > 0");
  } else {
    part.shape = shape == "sphere" ? Part::Shape::kSphere : Part::Shape::kCylinder;
    part.radius = node.quantity("radius", "m", kPositive);
  }
  if (part.shape == Part::Shape::kCylinder) {
    part.length = node.quantity("length", "m", kPositive);
    if (const auto axis = node.find("axis")) part.axis = readAxis(*axis);
  }
  part.position = node.vectorQuantity("position", "m");
  const auto density = node.findQuantity("density", "kg_m3", kPositive);
  if (density && node.hasQuantity("mass", "kg")) node.fail("found both a mass and a density, expected one of them");
  part.mass = density ? *density * volume(part) : node.quantity("mass", "kg", kPositive);
  return part;
}

Body readBodyEntry(const YamlNode& node, std::set<std::string>& names) {
  Body body;
  body.name = readName(node, names);
  if (const auto fixed = node.find("fixed")) body.fixed = fixed->boolean();
  const auto parts = node.find("parts");
  if (!parts && !body.fixed) node.fail("a body that moves needs 'parts' (mass > 0)");
  if (!parts) return body;
  std::set<std::string> part_names;
  for (const YamlNode& part : parts->items()) body.parts.push_back(readPart(part, part_names));
  if (body.parts.empty() && !body.fixed) parts->fail("found no part, expected at least one (mass > 0)");
  return body;
}

Joint readJoint(const YamlNode& node, const std::vector<Body>& bodies, std::set<std::string>& names) {
  Joint joint;
  joint.name = readName(node, names);
  joint.type = readJointType(node.at("type"));
  joint.parent = readBody(node.at("parent"), bodies);
  joint.child = readBody(node.at("child"), bodies);
  joint.parent_position = node.vectorQuantity("parent_position", "m");
  joint.child_position = node.vectorQuantity("child_position", "m");
  if (kindOf(joint.type).has_axis) {
    joint.axis = readAxis(node.at("axis"));
    joint.lower_limit = node.findQuantity("lower_limit", "rad").value_or(-Joint::kUnlimited);
    joint.upper_limit = node.findQuantity("upper_limit", "rad").value_or(Joint::kUnlimited);
    if (joint.lower_limit > joint.upper_limit) {
      node.fail(fmt::format("lower_limit_rad {} is above upper_limit_rad {}", joint.lower_limit, joint.upper_limit));
    }
  }
  joint.coulomb_friction = node.findQuantity("coulomb_friction", "Nm", kNonNegative).value_or(0.0);
  joint.viscous_friction = node.findQuantity("viscous_friction", "Nms", kNonNegative).value_or(0.0);
  return joint;
}

/// A value given in the node, or the default; without a default it is required.
double readOr(const YamlNode& node, std::string_view stem, std::string_view unit, const Range& range,
              const double* fallback) {
  if (!fallback) return node.quantity(stem, unit, range);
  return node.findQuantity(stem, unit, range).value_or(*fallback);
}

Motor readMotor(const YamlNode& node, const Motor* fallback) {
  const auto read = [&](std::string_view stem, std::string_view unit, const Range& range, double Motor::*member) {
    return readOr(node, stem, unit, range, fallback ? &(fallback->*member) : nullptr);
  };
  Motor motor;
  motor.resistance = read("resistance", "ohm", kPositive, &Motor::resistance);
  motor.inductance = read("inductance", "H", kPositive, &Motor::inductance);
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

Muscle readMuscle(const YamlNode& node, const ArmModel& model, const YamlNode& root, std::set<std::string>& names) {
  Muscle muscle;
  muscle.name = readName(node, names);
  const YamlNode attachments = node.at("attachments");
  const std::vector<YamlNode> ends = attachments.items();
  if (ends.size() != 2) attachments.fail(fmt::format("found {} attachments, expected 2", ends.size()));
  for (std::size_t i = 0; i < 2; ++i) {
    muscle.attachments[i] = {readBody(ends[i].at("body"), model.bodies), ends[i].vectorQuantity("point", "m")};
  }
  if (muscle.attachments[0].body == muscle.attachments[1].body) {
    attachments.fail("both ends are on the same body, expected two bodies");
  }
  if (const auto path = node.find("path")) path->oneOf({"straight"});
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

/// Orders the joints from the fixed bodies outwards and refuses anything that is not a forest rooted in fixed bodies.
void checkAndSortTree(ArmModel& model, const YamlNode& joints) {
  std::vector<Joint> sorted;
  std::vector<bool> reached(model.bodies.size());
  std::vector<int> parents(model.bodies.size(), 0);
  for (std::size_t i = 0; i < model.bodies.size(); ++i) reached[i] = model.bodies[i].fixed;
  for (const Joint& joint : model.joints) {
    if (model.bodies[joint.child].fixed) {
      joints.fail(fmt::format("joint '{}' moves the fixed body '{}'", joint.name, model.bodies[joint.child].name));
    }
    if (++parents[joint.child] > 1) {
      joints.fail(fmt::format("body '{}' is the child of two joints, expected one", model.bodies[joint.child].name));
    }
  }
  std::vector<Joint> waiting = model.joints;
  for (bool progress = true; progress && !waiting.empty();) {
    progress = false;
    std::vector<Joint> still;
    for (Joint& joint : waiting) {
      if (!reached[joint.parent]) {
        still.push_back(std::move(joint));
        continue;
      }
      reached[joint.child] = true;
      sorted.push_back(std::move(joint));
      progress = true;
    }
    waiting = std::move(still);
  }
  for (std::size_t i = 0; i < model.bodies.size(); ++i) {
    if (!reached[i]) {
      joints.fail(fmt::format("body '{}' is not connected to a fixed body by joints", model.bodies[i].name));
    }
  }
  model.joints = std::move(sorted);
}

void readBodiesAndJoints(const YamlNode& root, ArmModel& model) {
  std::set<std::string> names;
  for (const YamlNode& body : root.at("bodies").items()) model.bodies.push_back(readBodyEntry(body, names));
  const YamlNode joints = root.at("joints");
  std::set<std::string> joint_names;
  for (const YamlNode& joint : joints.items()) model.joints.push_back(readJoint(joint, model.bodies, joint_names));
  if (model.joints.empty()) joints.fail("found no joint, expected at least one");
  checkAndSortTree(model, joints);
}

}  // namespace

ArmModel readArm(const YamlNode& root) {
  ArmModel model;
  root.at("format").oneOf({"simgap/arm/1"});
  model.name = root.at("name").text();
  model.gravity = root.vectorQuantity("gravity", "m_s2");
  readBodiesAndJoints(root, model);
  if (const auto node = root.find("motor_defaults")) model.motor_defaults = readMotor(*node, nullptr);
  if (const auto node = root.find("gearbox_defaults")) model.gearbox_defaults = readGearbox(*node, nullptr);
  std::set<std::string> names;
  for (const YamlNode& muscle : root.at("muscles").items()) {
    model.muscles.push_back(readMuscle(muscle, model, root, names));
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
