/// \file
/// An arm with every kind of joint, part, station and tendon that `simgap/arm/2` knows.
#pragma once

namespace simgap::test {

inline constexpr const char* kManyKinds = R"(format: simgap/arm/2
name: many-kinds
gravity_m_s2: [0.3, -0.5, -9.7]
bodies:
  - name: base
    fixed: true
    surfaces:
      - {name: ball, shape: sphere, radius_m: 0.03, position_m: [0.01, 0.02, -0.05]}
  - name: carriage
    parts:
      - {name: plate, shape: box, size_m: [0.1, 0.05, 0.02], mass_kg: 0.3, position_m: [0.01, 0, 0], orientation: [0.6, 0, 0.8, 0]}
    surfaces:
      - {name: roll, shape: cylinder, radius_m: 0.02, position_m: [0, 0.01, -0.06], axis: [1, 0.2, 0]}
  - name: upper
    parts:
      - {name: tube, shape: capsule, radius_m: 0.01, length_m: 0.1, mass_kg: 0.25, position_m: [0, 0, -0.08], axis: [0, 0, 1]}
    surfaces:
      - {name: elbow_roll, shape: cylinder, radius_m: 0.015, position_m: [0, 0, -0.2], axis: [1, 0, 0]}
  - name: lower
    parts:
      - {name: egg, shape: ellipsoid, semi_axes_m: [0.01, 0.02, 0.06], mass_kg: 0.2, position_m: [0, 0.01, -0.07], orientation: [0.8, 0.6, 0, 0]}
  - name: tip
    parts:
      - {name: stated, shape: inertia, mass_kg: 0.05, position_m: [0, 0, -0.02], inertia_kg_m2: [2e-5, 2e-5, 1e-5], products_kg_m2: [1e-6, 0, 0]}
  - name: nail
    parts:
      - {name: drop, shape: sphere, radius_m: 0.005, mass_kg: 0.01, position_m: [0, 0, 0]}
joints:
  - {name: slide, type: prismatic, parent: base, child: carriage, parent_position_m: [0, 0, 0.1], child_position_m: [0, 0.01, 0], parent_rpy_rad: [0.2, -0.3, 0.4], axis: [1, 0, 0], lower_limit_m: -0.2, upper_limit_m: 0.3, spring: {stiffness_N_m: 300, rest_m: 0.02}, viscous_friction_Ns_m: 20}
  - {name: ball, type: spherical, parent: carriage, child: upper, parent_position_m: [0.02, 0, -0.02], child_position_m: [0, 0, 0.01], parent_orientation: [0.96, 0.28, 0, 0], child_orientation: [0.8, 0, 0.6, 0], spring: {stiffness_Nm_rad: 1.5}, viscous_friction_Nms: 0.1}
  - {name: hinge, type: revolute, parent: upper, child: lower, parent_position_m: [0, 0, -0.2], child_position_m: [0, 0.005, 0], child_rpy_rad: [0.3, 0.1, 0], axis: [1, 0, 0], lower_limit_rad: -0.5, upper_limit_rad: 2.0, spring: {stiffness_Nm_rad: 0.4, rest_rad: 0.3}, viscous_friction_Nms: 0.05}
  - {name: follower, type: revolute, parent: lower, child: tip, parent_position_m: [0, 0, -0.14], child_position_m: [0, 0, 0], axis: [1, 0, 0], follows: {joint: hinge, ratio: 0.6, offset_rad: 0.1}, viscous_friction_Nms: 0.01}
  - {name: weld, type: fixed, parent: tip, child: nail, parent_position_m: [0, 0.002, -0.05], child_position_m: [0, 0, 0], parent_rpy_rad: [0.5, 0, 0]}
motor_defaults: {resistance_ohm: 0.8, inductance_H: 0.0003, back_emf_constant_Vs: 0.011, torque_constant_Nm_A: 0.011, inertia_kg_m2: 2.0e-6, viscous_friction_Nms: 1.0e-6, coulomb_friction_Nm: 0.002, supply_voltage_V: 12}
gearbox_defaults: {ratio: 72, efficiency: 0.72, inertia_kg_m2: 1.0e-5, viscous_friction_Nms: 0.002, coulomb_friction_Nm: 0.03}
muscles:
  - name: straight
    attachments: [{body: base, point_m: [0.05, 0.08, 0.05]}, {body: upper, point_m: [0.01, 0.02, -0.12]}]
    kite_line_length_m: 0.11
    shock_cord: {rest_length_m: 0.08, stiffness_N_m: 500, damping_Ns_m: 15}
    spindle_radius_m: 0.006
  - name: within
    attachments: [{body: upper, point_m: [0.01, -0.03, -0.1]}, {body: lower, point_m: [0, -0.025, -0.03]}]
    kite_line_length_m: 0.04
    shock_cord: {rest_length_m: 0.06, stiffness_N_m: 400, damping_Ns_m: 15}
    spindle_radius_m: 0.006
  - name: routed
    attachments:
      - {body: base, point_m: [0.06, -0.05, 0.02]}
      - {over: ball, body: base}
      - {body: upper, point_m: [-0.01, 0.03, -0.05]}
      - {body: upper, point_m: [0, 0.03, -0.16]}
      - {over: elbow_roll, body: upper, side_m: [0, 0.05, -0.2]}
      - {joint: follower, radius_m: 0.008}
      - {body: lower, point_m: [0.005, 0.025, -0.05]}
    kite_line_length_m: 0.3
    shock_cord: {rest_length_m: 0.08, stiffness_N_m: 600, damping_Ns_m: 15}
    spindle_radius_m: 0.006
  - name: branched
    attachments:
      - {body: base, point_m: [-0.05, 0.05, 0.06]}
      - {over: roll, body: carriage}
      - {body: upper, point_m: [0, -0.03, -0.06]}
      - {pulley: 2}
      - {body: upper, point_m: [0, -0.03, -0.06]}
      - {body: lower, point_m: [0.01, -0.02, -0.04]}
      - {pulley: 3}
      - {body: upper, point_m: [0.02, -0.03, -0.06]}
      - {over: elbow_roll, body: upper}
      - {body: tip, point_m: [0, -0.02, -0.02]}
    kite_line_length_m: 0.12
    shock_cord: {rest_length_m: 0.08, stiffness_N_m: 700, damping_Ns_m: 15}
    spindle_radius_m: 0.007
tendons:
  - name: ligament
    kind: ligament
    attachments: [{body: carriage, point_m: [0.03, 0.03, 0]}, {body: upper, point_m: [0.02, 0.03, -0.04]}]
    rest_length_m: 0.03
    stiffness_N_m: 300
    damping_Ns_m: 3
  - name: spring
    kind: spring
    attachments: [{body: base, point_m: [0, 0.2, 0]}, {over: elbow_roll, body: upper, side_m: [0, -0.06, -0.2]}, {body: nail, point_m: [0, 0, 0.01]}]
    rest_length_m: 0.25
    stiffness_N_m: 50
    damping_Ns_m: 2
  - name: weight
    kind: constant-force
    attachments: [{joint: hinge, radius_m: 0.02}, {joint: slide, ratio: 0.5}]
    force_N: 3
)";

}  // namespace simgap::test
