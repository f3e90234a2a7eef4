#include <fmt/format.h>
#include <fmt/ranges.h>

#include <algorithm>

#include "arm_yaml_parts.h"
#include "simgap/core/joint_kind.h"
#include "simgap/model/arm/arm_yaml.h"

namespace simgap {
namespace {

// {} of a double is the shortest text that reads back as the same bits.
std::string vector(const Eigen::Vector3d& v) { return fmt::format("[{}, {}, {}]", v.x(), v.y(), v.z()); }

std::string quaternion(const Eigen::Quaterniond& q) {
  return fmt::format("[{}, {}, {}, {}]", q.w(), q.x(), q.y(), q.z());
}

bool turned(const Eigen::Quaterniond& q) { return q.coeffs() != Eigen::Quaterniond::Identity().coeffs(); }

std::string shape(const Part& p) {
  switch (p.shape) {
    case Part::Shape::kSphere:
      return fmt::format("shape: sphere, radius_m: {}", p.radius);
    case Part::Shape::kBox:
      return fmt::format("shape: box, size_m: {}", vector(p.size));
    case Part::Shape::kEllipsoid:
      return fmt::format("shape: ellipsoid, semi_axes_m: {}", vector(p.size));
    case Part::Shape::kInertia:
      return fmt::format("shape: inertia, inertia_kg_m2: {}, products_kg_m2: {}", vector(p.inertia.diagonal()),
                         vector({p.inertia(0, 1), p.inertia(0, 2), p.inertia(1, 2)}));
    case Part::Shape::kCylinder:
    case Part::Shape::kCapsule:
      break;
  }
  return fmt::format("shape: {}, radius_m: {}, length_m: {}, axis: {}",
                     p.shape == Part::Shape::kCapsule ? "capsule" : "cylinder", p.radius, p.length, vector(p.axis));
}

bool hasOrientation(const Part& p) {
  return (p.shape == Part::Shape::kBox || p.shape == Part::Shape::kEllipsoid) && turned(p.orientation);
}

std::string part(const Part& p) {
  std::string text = fmt::format("      - {{name: {}, {}, mass_kg: {}, position_m: {}", yamlText(p.name), shape(p),
                                 p.mass, vector(p.position));
  if (hasOrientation(p)) text += ", orientation: " + quaternion(p.orientation);
  return text + "}\n";
}

std::string surface(const Surface& s) {
  const bool ball = s.shape == Surface::Shape::kSphere;
  return fmt::format("      - {{name: {}, shape: {}, radius_m: {}, position_m: {}{}}}\n", yamlText(s.name),
                     ball ? "sphere" : "cylinder", s.radius, vector(s.position),
                     ball ? "" : ", axis: " + vector(s.axis));
}

std::string body(const Body& b) {
  std::string text = fmt::format("  - name: {}\n", yamlText(b.name));
  if (b.fixed) text += "    fixed: true\n";
  if (!b.parts.empty()) text += "    parts:\n";
  for (const Part& p : b.parts) text += part(p);
  if (!b.surfaces.empty()) text += "    surfaces:\n";
  for (const Surface& s : b.surfaces) text += surface(s);
  return text;
}

std::string stop(const BallStop& s) {
  std::string text;
  if (s.swing < Joint::kUnlimited) text += fmt::format(", swing_rad: {}", s.swing);
  if (s.lower_twist > -Joint::kUnlimited) text += fmt::format(", lower_twist_rad: {}", s.lower_twist);
  if (s.upper_twist < Joint::kUnlimited) text += fmt::format(", upper_twist_rad: {}", s.upper_twist);
  return text + fmt::format(", stiffness_Nm_rad: {}", s.stiffness);
}

std::string springAndLeader(const Joint& j, const ArmModel& model) {
  const auto unit = [&](std::string_view name) { return arm_yaml::jointUnit(j, name); };
  std::string text;
  if (turned(j.parent_orientation)) text += ", parent_orientation: " + quaternion(j.parent_orientation);
  if (turned(j.child_orientation)) text += ", child_orientation: " + quaternion(j.child_orientation);
  if (j.spring_stiffness > 0.0) {
    text += fmt::format(", spring: {{stiffness_{}: {}", unit("Nm_rad"), j.spring_stiffness);
    text += j.hasAxis() ? fmt::format(", rest_{}: {}}}", unit("rad"), j.spring_rest) : "}";
  }
  if (j.stop.stiffness > 0.0) text += ", limits: {axis: " + vector(j.axis) + stop(j.stop) + "}";
  if (j.follows()) {
    text += fmt::format(", follows: {{joint: {}, ratio: {}, offset_{}: {}}}", yamlText(model.joints[j.leader].name),
                        j.coupling_ratio, unit("rad"), j.coupling_offset);
  }
  return text;
}

std::string joint(const Joint& j, const ArmModel& model) {
  const auto unit = [&](std::string_view name) { return arm_yaml::jointUnit(j, name); };
  std::string text =
      fmt::format("  - {{name: {}, type: {}, parent: {}, child: {}, parent_position_m: {}, child_position_m: {}",
                  yamlText(j.name), kindOf(j.type).name, yamlText(model.bodies[j.parent].name),
                  yamlText(model.bodies[j.child].name), vector(j.parent_position), vector(j.child_position));
  if (j.hasAxis()) {
    text += fmt::format(", axis: {}", vector(j.axis));
    if (j.lower_limit > -Joint::kUnlimited) text += fmt::format(", lower_limit_{}: {}", unit("rad"), j.lower_limit);
    if (j.upper_limit < Joint::kUnlimited) text += fmt::format(", upper_limit_{}: {}", unit("rad"), j.upper_limit);
  }
  text += springAndLeader(j, model);
  return text + fmt::format(", coulomb_friction_{}: {}, viscous_friction_{}: {}}}\n", unit("Nm"), j.coulomb_friction,
                            unit("Nms"), j.viscous_friction);
}

std::string side(const Station& s, const ArmModel& model) {
  if (!s.sided) return "";
  const std::string body = s.side_body < 0 ? "" : ", side_body: " + yamlText(model.bodies[s.side_body].name);
  return ", side_m: " + vector(s.at.point) + body;
}

std::string station(const Station& s, const ArmModel& model) {
  switch (s.kind) {
    case Station::Kind::kSurface: {
      const Body& body = model.bodies[s.at.body];
      return fmt::format("{{over: {}, body: {}{}}}", yamlText(body.surfaces[s.surface].name), yamlText(body.name),
                         side(s, model));
    }
    case Station::Kind::kPulley:
      return fmt::format("{{pulley: {}}}", s.divisor);
    case Station::Kind::kJoint: {
      const Joint& joint = model.joints[s.joint];
      return fmt::format("{{joint: {}, {}: {}}}", yamlText(joint.name), joint.slides() ? "ratio" : "radius_m",
                         s.radius);
    }
    case Station::Kind::kPoint:
      break;
  }
  return fmt::format("{{body: {}, point_m: {}}}", yamlText(model.bodies[s.at.body].name), vector(s.at.point));
}

std::string attachments(const TendonPath& path, const ArmModel& model) {
  std::vector<std::string> texts;
  for (const Station& s : path.between) texts.push_back(station(s, model));
  if (!path.jointsOnly()) {
    texts.insert(texts.begin(), station({Station::Kind::kPoint, path.attachments[0]}, model));
    texts.push_back(station({Station::Kind::kPoint, path.attachments[1]}, model));
  }
  return fmt::format("    attachments: [{}]\n", fmt::join(texts, ", "));
}

std::string tendon(const PassiveTendon& t, const ArmModel& model) {
  std::string text = fmt::format("  - name: {}\n    kind: {}\n", yamlText(t.name), t.kind->name);
  text += t.kind->at_joint ? fmt::format("    joint: {}\n", yamlText(model.joints[t.between[0].joint].name))
                           : attachments(t, model);
  for (std::size_t i = 0; i < t.kind->parameters.size(); ++i) {
    text += fmt::format("    {}: {}\n", t.kind->parameters[i].key, t.p[i]);
  }
  return text;
}

bool needsSecondVersion(const ArmModel& model) {
  const auto newShape = [](const Part& p) { return p.shape > Part::Shape::kBox || hasOrientation(p); };
  return !model.tendons.empty() || std::ranges::any_of(model.bodies, [&](const Body& b) {
    return !b.surfaces.empty() || (b.parts.empty() && !b.fixed) || std::ranges::any_of(b.parts, newShape);
  }) || std::ranges::any_of(model.joints, [&](const Joint& j) {
    return j.slides() || !springAndLeader(j, model).empty();
  }) || !std::ranges::all_of(model.muscles, [](const Muscle& m) { return m.straight() && !m.rope; });
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
  std::string text = fmt::format("  - name: {}\n", yamlText(m.name)) + attachments(m, model);
  if (m.rope) text += "    line: rope\n";
  text += fmt::format(
      "    kite_line_length_m: {}\n    shock_cord: {{rest_length_m: {}, stiffness_N_m: {}, damping_Ns_m: {}}}\n"
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
  std::string text = fmt::format("format: simgap/arm/{}\nname: {}\ngravity_m_s2: {}\nbodies:\n",
                                 needsSecondVersion(model) ? 2 : 1, yamlText(model.name), vector(model.gravity));
  for (const Body& b : model.bodies) text += body(b);
  text += "joints:\n";
  for (const Joint& j : model.joints) text += joint(j, model);
  const bool defaults = model.motor_defaults.resistance > 0.0;
  const bool gearbox_defaults = model.gearbox_defaults != Gearbox{};
  const std::string motor_default = defaults ? motor(model.motor_defaults) : "";
  const std::string gearbox_default = gearbox_defaults ? gearbox(model.gearbox_defaults) : "";
  if (defaults) text += "motor_defaults: " + motor_default;
  if (gearbox_defaults) text += "gearbox_defaults: " + gearbox_default;
  text += model.muscles.empty() ? "muscles: []\n" : "muscles:\n";
  for (const Muscle& m : model.muscles) text += muscle(m, model, motor_default, gearbox_default);
  if (!model.tendons.empty()) text += "tendons:\n";
  for (const PassiveTendon& t : model.tendons) text += tendon(t, model);
  if (!model.extensions.empty()) text += writeExtensions(model.extensions);
  return text;
}

}  // namespace simgap
