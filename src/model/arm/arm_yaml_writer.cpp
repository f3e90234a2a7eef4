#include <fmt/format.h>

#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap {
namespace {

// {} of a double is the shortest text that reads back as the same bits.
std::string vector(const Eigen::Vector3d& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }

std::string part(const Part& p) {
  std::string shape;
  switch (p.shape) {
    case Part::Shape::kSphere:
      shape = fmt::format("shape: sphere, radius_m: {}", p.radius);
      break;
    case Part::Shape::kBox:
      shape = fmt::format("shape: box, size_m: {}", vector(p.size));
      break;
    case Part::Shape::kCylinder:
      shape = fmt::format("shape: cylinder, radius_m: {}, length_m: {}, axis: {}", p.radius, p.length, vector(p.axis));
      break;
  }
  return fmt::format("      - {{name: {}, {}, mass_kg: {}, position_m: {}}}\n", yamlText(p.name), shape, p.mass,
                     vector(p.position));
}

std::string joint(const Joint& j, const std::vector<Body>& bodies) {
  std::string text =
      fmt::format("  - {{name: {}, type: {}, parent: {}, child: {}, parent_position_m: {}, child_position_m: {}",
                  yamlText(j.name), kindOf(j.type).name, yamlText(bodies[j.parent].name),
                  yamlText(bodies[j.child].name), vector(j.parent_position), vector(j.child_position));
  if (kindOf(j.type).has_axis) {
    text += fmt::format(", axis: {}", vector(j.axis));
    if (j.lower_limit > -Joint::kUnlimited) text += fmt::format(", lower_limit_rad: {}", j.lower_limit);
    if (j.upper_limit < Joint::kUnlimited) text += fmt::format(", upper_limit_rad: {}", j.upper_limit);
  }
  return text +
         fmt::format(", coulomb_friction_Nm: {}, viscous_friction_Nms: {}}}\n", j.coulomb_friction, j.viscous_friction);
}

std::string motor(const Motor& m) {
  return fmt::format(
      "{{resistance_ohm: {}, inductance_H: {}, back_emf_constant_Vs: {}, torque_constant_Nm_A: {}, inertia_kg_m2: {}, "
      "viscous_friction_Nms: {}, coulomb_friction_Nm: {}, supply_voltage_V: {}}}\n",
      m.resistance, m.inductance, m.back_emf_constant, m.torque_constant, m.inertia, m.viscous_friction,
      m.coulomb_friction, m.supply_voltage);
}

std::string gearbox(const Gearbox& g) {
  return fmt::format(
      "{{ratio: {}, efficiency: {}, inertia_kg_m2: {}, viscous_friction_Nms: {}, coulomb_friction_Nm: {}}}\n", g.ratio,
      g.efficiency, g.inertia, g.viscous_friction, g.coulomb_friction);
}

std::string muscle(const Muscle& m, const ArmModel& model, const std::string& motor_default,
                   const std::string& gearbox_default) {
  std::string text = fmt::format("  - name: {}\n    attachments: [", yamlText(m.name));
  for (std::size_t i = 0; i < 2; ++i) {
    text += fmt::format("{}{{body: {}, point_m: {}}}", i ? ", " : "",
                        yamlText(model.bodies[m.attachments[i].body].name), vector(m.attachments[i].point));
  }
  text += fmt::format(
      "]\n    kite_line_length_m: {}\n    shock_cord: {{rest_length_m: {}, stiffness_N_m: {}, damping_Ns_m: {}}}\n"
      "    spindle_radius_m: {}\n",
      m.kite_line_length, m.shock_cord.rest_length, m.shock_cord.stiffness, m.shock_cord.damping, m.spindle_radius);
  if (m.potentiometer_initial != 0.0) {
    text += fmt::format("    potentiometer: {{initial_rad: {}}}\n", m.potentiometer_initial);
  }
  if (motor(m.motor) != motor_default) text += "    motor: " + motor(m.motor);
  if (gearbox(m.gearbox) != gearbox_default) text += "    gearbox: " + gearbox(m.gearbox);
  return text;
}

}  // namespace

std::string writeArm(const ArmModel& model) {
  std::string text = fmt::format("format: simgap/arm/1\nname: {}\ngravity_m_s2: {}\nbodies:\n", yamlText(model.name),
                                 vector(model.gravity));
  for (const Body& body : model.bodies) {
    text += fmt::format("  - name: {}\n", yamlText(body.name));
    if (body.fixed) text += "    fixed: true\n";
    if (!body.parts.empty()) text += "    parts:\n";
    for (const Part& p : body.parts) text += part(p);
  }
  text += "joints:\n";
  for (const Joint& j : model.joints) text += joint(j, model.bodies);
  const bool defaults = model.motor_defaults.resistance > 0.0;
  const bool gearbox_defaults = model.gearbox_defaults != Gearbox{};
  const std::string motor_default = defaults ? motor(model.motor_defaults) : "";
  const std::string gearbox_default = gearbox_defaults ? gearbox(model.gearbox_defaults) : "";
  if (defaults) text += "motor_defaults: " + motor_default;
  if (gearbox_defaults) text += "gearbox_defaults: " + gearbox_default;
  text += model.muscles.empty() ? "muscles: []\n" : "muscles:\n";
  for (const Muscle& m : model.muscles) text += muscle(m, model, motor_default, gearbox_default);
  if (!model.extensions.empty()) text += writeExtensions(model.extensions);
  return text;
}

}  // namespace simgap
