/// \file
/// Torques that lift a standing leg by a vertical force at its centre of mass (002 section III-D), for simulators and
/// controllers: one header without dependencies.
///
///     tau = J^T F,   J = d z_c / d q,   F = share M g                   002 eq. 19
///
/// The leg stands on its foot and moves in one plane: the shank turns about the ankle by q_1 from the vertical, the
/// thigh about the knee by q_2 from the shank's line, both positive towards the front; the weight of the rest of the
/// body acts in the hip (the trunk is kept upright by whom it belongs to). With a share of 1 the torques are those of
/// gravity.
#pragma once

#include <algorithm>
#include <array>
#include <cmath>

#include "simgap/core/units.h"

namespace simgap {

struct LegSegment {
  double length = 0.0;  ///< [m]
  double centre = 0.0;  ///< of its mass, from its lower joint [m]
  double mass = 0.0;    ///< [kg]
};

/// Per joint: ankle, knee.
using LegTorques = std::array<double, 2>;  ///< [N m]

struct PlanarLeg {
  LegSegment shank, thigh;
  double load = 0.0;               ///< carried in the hip [kg]
  double gravity = kEarthGravity;  ///< [m/s^2]

  double mass() const noexcept { return shank.mass + thigh.mass + load; }
  /// Masses times levers of the shank and of the thigh. [kg m]
  std::array<double, 2> moments() const noexcept {
    return {shank.mass * shank.centre + (thigh.mass + load) * shank.length,
            thigh.mass * thigh.centre + load * thigh.length};
  }
  /// z_c above the ankle. [m]
  double centreHeight(double ankle, double knee) const noexcept {
    const auto [of_shank, of_thigh] = moments();
    return (of_shank * std::cos(ankle) + of_thigh * std::cos(ankle + knee)) / mass();
  }
  double hipHeight(double ankle, double knee) const noexcept {
    return shank.length * std::cos(ankle) + thigh.length * std::cos(ankle + knee);
  }
  /// J^T F of a vertical force at the centre of mass [N].
  LegTorques lifting(double ankle, double knee, double force) const noexcept {
    const auto [of_shank, of_thigh] = moments();
    const double by_knee = -of_thigh * std::sin(ankle + knee) / mass();
    return {force * (by_knee - of_shank * std::sin(ankle) / mass()), force * by_knee};
  }
};

struct VerticalAssist {
  double share = 1.0;      ///< of the weight
  LegTorques limits = {};  ///< of each joint's drive [N m]
  double rise_time = 0.5;  ///< in which the force comes and goes, as a lag of first order [s]

  /// \param[in,out] level  0 … 1, how much of the force is there; kept by the caller  \param step [s]
  LegTorques update(const PlanarLeg& leg, double ankle, double knee, bool up, double step,
                    double& level) const noexcept {
    level += (1.0 - std::exp(-step / rise_time)) * ((up ? 1.0 : 0.0) - level);
    LegTorques torques = leg.lifting(ankle, knee, level * share * leg.mass() * leg.gravity);
    for (std::size_t i = 0; i < torques.size(); ++i) torques[i] = std::clamp(torques[i], -limits[i], limits[i]);
    return torques;
  }
};

}  // namespace simgap
