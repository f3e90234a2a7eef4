/// \file
/// A leg in an exoskeleton that stands up when it is told to (002 section III-D and IV-B): `format: simgap/exo-leg/1`.
/// SI.
#pragma once

#include <string>

#include "simgap/core/yaml.h"
#include "simgap/model/actuator/vertical_assist.h"

namespace simgap {

/// What the person does: he bears a part of the weight, and leans so that his hip stays on its way between seat and
/// standing, by a horizontal force (which the paper leaves to the upper body).
struct LegUser {
  double strength = 0.0;              ///< share of gravity's torques
  double horizontal_stiffness = 0.0;  ///< of the hip towards its way [N/m]
  double horizontal_damping = 0.0;    ///< [N s/m]
  double horizontal_limit = 0.0;      ///< [N]
};

struct ExoLeg {
  std::string name;
  PlanarLeg leg;
  double shank_inertia = 0.0, thigh_inertia = 0.0;  ///< about their centres of mass [kg m^2]
  LegTorques viscous = {};                          ///< of the joints [N m s/rad]
  std::array<double, 2> sitting = {};               ///< angles on the seat [rad]; standing is 0, 0
  double seat_stiffness = 0.0, seat_damping = 0.0;  ///< vertical, below the hip [N/m], [N s/m]
  LegUser user;
  VerticalAssist assist;
  double rate = 500.0;  ///< of the controller [Hz]
};

/// \throws ConfigError: all that YamlNode refuses, a seat on which the leg stands
ExoLeg readExoLeg(const YamlNode& root);

}  // namespace simgap
