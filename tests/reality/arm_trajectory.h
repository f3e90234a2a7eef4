/// \file
/// How a tendon-driven arm moves: every body on its own, held together by the forces of constraint.
///
/// A judge of the simulation: it shares no code with it, and no method. The simulation works in joint coordinates with
/// composite inertias; here each link has six, and joints are equations on accelerations whose multipliers are the
/// reactions,
///
///     [ M  -G^T ] [ a      ]   [ f      ]
///     [ G   0   ] [ lambda ] = [ -gamma ],
///
/// integrated by Runge-Kutta of fourth order. Motors, gearboxes and their P controllers (000 eq. 8-12) are integrated
/// along. Neither Coulomb friction nor joint limits: what is compared is smooth.
#pragma once

#include <vector>

#include "reality/arm_statics.h"

namespace simgap::reality {

/// DC motor and gearbox without Coulomb friction.
struct SmoothDrive {
  double resistance = 0.8, inductance = 0.0003, back_emf = 0.011, torque_constant = 0.011;
  double motor_inertia = 2.0e-6, motor_viscous = 1.0e-6;
  double ratio = 72.0, efficiency = 0.72, gear_inertia = 1.0e-5, gear_viscous = 0.002;
  double supply = 12.0, gain = 50.0;  ///< [V], [V/rad]
  double tick = 0.002;                ///< [s] of the controller
};

/// The motion from restPose() with all shafts at 0.
/// \param references  of the shafts, shape (muscles) [rad]  \param step  [s], a whole part of the tick
/// \param interval  [s] between the configurations that are returned, a whole number of ticks; the first is at 0
std::vector<Configuration> play(const Arm& arm, const SmoothDrive& drive, const std::vector<double>& references,
                                double step, double interval, double end);

}  // namespace simgap::reality
