/// \file
/// An arm with one part of every shape, no defaults, and joints that stand in the wrong order.
#pragma once

#include <string>

namespace simgap::test {

inline const std::string kSmallArm = R"(format: simgap/arm/1
name: small
gravity_m_s2: [0, 0, -9.81]
bodies:
  - {name: torso, fixed: true}
  - name: humerus
    parts:
      - {name: bone, shape: cylinder, radius_m: 0.018, length_m: 0.28, mass_kg: 0.31, position_m: [0, 0, -0.14]}
  - name: forearm
    parts:
      - {name: hand, shape: sphere, radius_mm: 40, density_kg_m3: 1100, position_m: [0, 0, -0.3]}
      - {name: plate, shape: box, size_m: [0.1, 0.02, 0.03], mass_g: 70, position_m: [0, 0, -0.1]}
joints:
  - {name: elbow, type: revolute, parent: humerus, child: forearm, parent_position_m: [0, 0, -0.28], child_position_m: [0, 0, 0], axis: [1, 2, 3], upper_limit_deg: 135}
  - {name: shoulder, type: spherical, parent: torso, child: humerus, parent_position_m: [0, 0, 0], child_position_m: [0, 0, 0.01]}
muscles:
  - name: biceps
    attachments: [{body: torso, point_m: [0.01, 0.07, 0.05]}, {body: forearm, point_m: [0, 0.02, -0.1]}]
    kite_line_length_m: 0.1
    shock_cord: {rest_length_m: 0.08, stiffness_N_m: 900, damping_Ns_m: 15}
    spindle_radius_m: 0.006
    potentiometer: {initial_deg: 33.3}
    motor: {resistance_ohm: 0.8, inductance_mH: 0.3, back_emf_constant_Vs: 0.011, torque_constant_Nm_A: 0.011, inertia_kg_m2: 2.0e-6, viscous_friction_Nms: 1.0e-6, coulomb_friction_Nm: 0.002, supply_voltage_V: 12}
    gearbox: {ratio: 72, efficiency: 0.72, inertia_kg_m2: 1.0e-5, viscous_friction_Nms: 0.002, coulomb_friction_Nm: 0.03}
)";

}  // namespace simgap::test
