/// \file
/// Whether a robot that went into another format and back is still the same: its bodies are where they were.
#pragma once

#include "simgap/model/arm/arm.h"

namespace simgap {

/// Largest differences between two arms, body by body.
struct ExchangeReplay {
  int positions = 0;       ///< random positions of all joints
  double way = 0.0;        ///< [m] between origins of the same body
  double turn = 0.0;       ///< [rad] between its orientations
  double mass = 0.0;       ///< [kg]
  double centre = 0.0;     ///< [m] between centres of mass
  double inertia = 0.0;    ///< about them, as a share of the body's own
  int rests = 0;           ///< random shafts (of muscles) for which both come to rest
  int restless = 0;        ///< for which only the first one does
  int not_compared = 0;    ///< for which the first one does not rest, or rounding alone says where
  double rest_way = 0.0;   ///< [m] between the same body at rest
  double rest_turn = 0.0;  ///< [rad]
};

/// \param original  extensions of it are left out: no other format has them
/// \param read_back  bodies and joints by the same names; a ball may have become hinges NAME_x, NAME_y, NAME_z
/// \param links_in_joints  bodies of `read_back` have their frames in their joints, as in URDF
/// \throws NumericsError when a body or a joint of `original` is missing in `read_back`
ExchangeReplay replayExchange(const ArmModel& original, const ArmModel& read_back, bool links_in_joints);

}  // namespace simgap
