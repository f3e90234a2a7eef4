/// \file
/// A carriage on a level rail between two cords, under it a pendulum that a cord turns over a wheel: an arm with a
/// slide of which everything can be said with a few lines of mechanics that no model shares.
#pragma once

#include <fmt/format.h>

#include <algorithm>
#include <cmath>
#include <string>
#include <vector>

namespace simgap::test {

/// Where it rests follows from two balances of forces, which are solved here; how it moves from Lagrange's equations of
/// a cart with a pendulum, its shafts held.
struct Gantry {
  double left = 0.30, right = 0.32, wheel = -0.075;  ///< kite lines [m]
  double stiffness_left = 400.0, stiffness_wheel = 300.0;
  double rail_viscous = 20.0, pivot_viscous = 0.05;  ///< [N s/m], [N m s]
  double ratio = 0.0;                                ///< not 0: no spring, and the pivot is at 0.1 + ratio * rail
  static constexpr double kCord = 0.08, kRight = 500.0, kSpindle = 0.006, kWheel = 0.03, kSpring = 0.6, kRest = 0.2;
  static constexpr double kCarriage = 0.5, kMass = 0.2, kRadius = 0.02, kLength = 0.15, kGravity = 9.81;
  static constexpr double kDamping = 20.0;  ///< of every cord [N s/m]

  double rail(double wound_left, double wound_right) const {
    // k_l (0.4 + x - L_l) = k_r (0.4 - x - L_r), L what line and cord have unstretched.
    const double l = left - kSpindle * wound_left + kCord, r = right - kSpindle * wound_right + kCord;
    return (kRight * (0.4 - r) - stiffness_left * (0.4 - l)) / (stiffness_left + kRight);
  }
  double pendulum(double wound) const {
    // Gravity and spring turn it back, the cord's R max(0, k (R q - L)) as well when it is long; bisection.
    const double l = wheel - kSpindle * wound + kCord;
    double low = -2.0, high = 2.0;
    for (int i = 0; i < 80; ++i) {
      const double q = 0.5 * (low + high);
      const double torque = kMass * kGravity * kLength * std::sin(q) + kSpring * (q - kRest) +
                            kWheel * std::max(0.0, stiffness_wheel * (kWheel * q - l));
      (torque > 0.0 ? high : low) = q;
    }
    return low;
  }

  struct State {
    double rail, pivot, rail_velocity, pivot_velocity;
  };
  /// Its accelerations, at shafts that are wound and held. T = 1/2 M X'^2 + 1/2 m |d/dt (X - l sin q, -l cos q)|^2 +
  /// 1/2 J q'^2 with the bob at X - l sin q.
  State derivative(const State& s, double wound_left, double wound_right, double wound_wheel) const {
    const auto pull = [](double stiffness, double stretch, double rate) {
      return stretch > 0.0 ? std::max(0.0, stiffness * stretch + kDamping * rate) : 0.0;
    };
    const double l = left - kSpindle * wound_left + kCord, r = right - kSpindle * wound_right + kCord;
    const double w = wheel - kSpindle * wound_wheel + kCord;
    const double sine = std::sin(s.pivot), cosine = std::cos(s.pivot);
    const double along = pull(kRight, 0.4 - s.rail - r, -s.rail_velocity) -
                         pull(stiffness_left, 0.4 + s.rail - l, s.rail_velocity) - rail_viscous * s.rail_velocity -
                         kMass * kLength * sine * s.pivot_velocity * s.pivot_velocity;
    const double about = -kMass * kGravity * kLength * sine - (ratio == 0.0 ? kSpring * (s.pivot - kRest) : 0.0) -
                         pivot_viscous * s.pivot_velocity -
                         kWheel * pull(stiffness_wheel, kWheel * s.pivot - w, kWheel * s.pivot_velocity);
    const double a = kCarriage + kMass, b = -kMass * kLength * cosine;
    const double c = kMass * (kLength * kLength + 0.4 * kRadius * kRadius), determinant = a * c - b * b;
    if (ratio != 0.0) {
      const double rail = (along + ratio * about) / (a + ratio * (2.0 * b + ratio * c));
      return {s.rail_velocity, s.pivot_velocity, rail, ratio * rail};
    }
    return {s.rail_velocity, s.pivot_velocity, (c * along - b * about) / determinant,
            (a * about - b * along) / determinant};
  }
  /// Its states from a state at rest, at 0, `interval`, 2 `interval`, … by Runge-Kutta of fourth order.
  std::vector<State> play(State s, double wound_left, double wound_right, double wound_wheel, double interval,
                          std::size_t count) const {
    constexpr int kParts = 1000;  // a cord that becomes taut jumps from nothing to what its damper does
    const double step = interval / kParts;
    const auto after = [](const State& from, const State& rate, double dt) -> State {
      return {from.rail + dt * rate.rail, from.pivot + dt * rate.pivot, from.rail_velocity + dt * rate.rail_velocity,
              from.pivot_velocity + dt * rate.pivot_velocity};
    };
    const auto at = [&](const State& x) { return derivative(x, wound_left, wound_right, wound_wheel); };
    std::vector<State> states{s};
    while (states.size() < count) {
      for (int i = 0; i < kParts; ++i) {
        const State k1 = at(s), k2 = at(after(s, k1, 0.5 * step)), k3 = at(after(s, k2, 0.5 * step)),
                    k4 = at(after(s, k3, step));
        s = after(after(after(after(s, k1, step / 6.0), k2, step / 3.0), k3, step / 3.0), k4, step / 6.0);
      }
      states.push_back(s);
    }
    return states;
  }

  /// \param dry_gear  friction of the gears: much of it holds the shafts against any cord [N m]
  std::string yaml(double dry_gear = 0.03) const {
    const auto muscle = [](const std::string& name, const std::string& way, double line, double stiffness) {
      return fmt::format(
          "  - name: {}\n    attachments: [{}]\n    kite_line_length_m: {}\n    shock_cord: {{rest_length_m: 0.08, "
          "stiffness_N_m: {}, damping_Ns_m: 20}}\n    spindle_radius_m: 0.006\n",
          name, way, line, stiffness);
    };
    return "format: simgap/arm/2\nname: gantry\ngravity_m_s2: [0, 0, -9.81]\nbodies:\n"
           "  - {name: frame, fixed: true}\n"
           "  - {name: carriage, parts: [{name: block, shape: box, size_m: [0.1, 0.1, 0.05], mass_kg: 0.5, position_m: "
           "[0, 0, 0]}]}\n"
           "  - {name: pendulum, parts: [{name: bob, shape: sphere, radius_m: 0.02, mass_kg: 0.2, position_m: [0, 0, "
           "-0.15]}]}\n"
           "joints:\n"
           "  - {name: rail, type: prismatic, parent: frame, child: carriage, parent_position_m: [0, 0, 0], "
           "child_position_m: [0, 0, 0], axis: [1, 0, 0], lower_limit_m: -0.3, upper_limit_m: 0.3, "
           "viscous_friction_Ns_m: " +
           fmt::format("{}", rail_viscous) +
           "}\n"
           "  - {name: pivot, type: revolute, parent: carriage, child: pendulum, parent_position_m: [0, 0, 0], "
           "child_position_m: [0, 0, 0], axis: [0, 1, 0], lower_limit_rad: -1.5, upper_limit_rad: 1.5, " +
           (ratio == 0.0 ? std::string("spring: {stiffness_Nm_rad: 0.6, rest_rad: 0.2}")
                         : fmt::format("follows: {{joint: rail, ratio: {}, offset_rad: 0.1}}", ratio)) +
           ", viscous_friction_Nms: " + fmt::format("{}", pivot_viscous) +
           "}\n"
           "motor_defaults: {resistance_ohm: 0.8, inductance_H: 0.0003, back_emf_constant_Vs: 0.011, "
           "torque_constant_Nm_A: 0.011, inertia_kg_m2: 2.0e-6, viscous_friction_Nms: 1.0e-6, coulomb_friction_Nm: "
           "0.002, supply_voltage_V: 12}\n"
           "gearbox_defaults: {ratio: 72, efficiency: 0.72, inertia_kg_m2: 1.0e-5, viscous_friction_Nms: 0.002, "
           "coulomb_friction_Nm: " +
           fmt::format("{}}}\nmuscles:\n", dry_gear) +
           muscle("left", "{body: frame, point_m: [-0.4, 0, 0]}, {body: carriage, point_m: [0, 0, 0]}", left,
                  stiffness_left) +
           muscle("right", "{body: frame, point_m: [0.4, 0, 0]}, {body: carriage, point_m: [0, 0, 0]}", right, kRight) +
           muscle("turner", "{joint: pivot, radius_m: 0.03}", wheel, stiffness_wheel);
  }
};

}  // namespace simgap::test
