/// \file
/// A joint that two pneumatic muscles and a motor turn (the paper's one-degree-of-freedom system, 002 section III) as a
/// file: `format: simgap/exo-joint/1` (docs/formats.md). SI units.
#pragma once

#include <functional>
#include <limits>
#include <optional>
#include <string>

#include "simgap/core/yaml.h"
#include "simgap/model/actuator/fitted_model.h"
#include "simgap/model/actuator/torque_split.h"

namespace simgap {

/// Motor with gear; its current follows its command at once.
struct ExoMotor {
  double torque_constant = 0.0;   ///< [N m/A]
  double ratio = 1.0;             ///< motor turns per joint turn
  double efficiency = 1.0;        ///< of the gear
  double current_limit = 0.0;     ///< [A]
  double inertia = 0.0;           ///< of the rotor [kg m^2]
  double coulomb_friction = 0.0;  ///< of the rotor [N m]
  double viscous_friction = 0.0;  ///< of the rotor [N m s]

  double torquePerAmpere() const { return torque_constant * ratio * efficiency; }  ///< at the joint [N m/A]
  double torqueLimit() const { return torquePerAmpere() * current_limit; }         ///< at the joint [N m]
};

/// What the joint turns, about the joint's axis.
struct ExoLink {
  double inertia = 0.0;             ///< [kg m^2]
  double weight = 0.0;              ///< mass times gravity times distance from the axis [N m]
  double hangs_at = 0.0;            ///< angle at which it hangs down [rad]
  double coulomb_friction = 0.0;    ///< [N m]
  double viscous_friction = 0.0;    ///< [N m s]
  double lower = 0.0, upper = 0.0;  ///< elastic stops [rad]
};

/// What a switch of two states asks of the joint.
struct ExoSwitch {
  double up = 0.0, down = 0.0;  ///< torques [N m]
  double rise_time = 0.3;       ///< of the lag between them [s]
};

struct ExoJoint {
  std::string name;
  AntagonistJoint muscles;
  double lowest_fitted = -std::numeric_limits<double>::infinity();  ///< contractions that the muscles' fits have seen
  double highest_fitted = std::numeric_limits<double>::infinity();
  double hysteresis = 0.0;  ///< h of the braid's friction [m^2]: f -= h p z
  double slip = 0.005;      ///< contraction over which its bristles bend before they slip
  double supply = 0.0;      ///< highest pressure [Pa]
  double valve_time = 0.0;  ///< of the valves with the muscles' filling [s]
  std::optional<ExoMotor> motor;
  ExoLink link;
  double rate = 500.0;     ///< of the controller [Hz]
  double crossover = 0.0;  ///< as TorqueSplitSettings
  CoContraction co_contraction;
  std::optional<ExoSwitch> by_switch;

  double motorLimit() const { return motor ? motor->torqueLimit() : 0.0; }  ///< [N m]
};

/// Force law of a muscle of that diameter [m] and braid angle [rad] without pressure (002 eq. 12); a stiff tendon.
Pam muscleOf(double diameter, double braid_angle);

/// Pulley, length and contractions at angle 0 of such a file, which may lack everything else.
AntagonistJoint readPulley(const YamlNode& root);

/// \param model  reads the file of a muscle that `fit-pam` has left (its path as it stands in the joint's file)
/// \throws ConfigError: all that YamlNode refuses, a muscle whose force never ends, one that the joint's limits stretch
/// or contract beyond what its law can say, a muscle with causes that were added to the law
ExoJoint readExoJoint(const YamlNode& root, const std::function<FittedModel(const std::string& file)>& model);

}  // namespace simgap
