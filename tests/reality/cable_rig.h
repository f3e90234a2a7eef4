/// \file
/// A motor, a Bowden cable and a joint with a lever, from equations of their own: friction is bristles between motor
/// and cable (LuGre: Canudas de Wit et al. 1995) whose static part fades hyperbolically, the cable stiffens as it is
/// pulled, and all is integrated by the classical Runge-Kutta method. It has nothing in common with the models that are
/// judged by it.
#pragma once

#include <functional>
#include <vector>

#include "reality/friction_log.h"

namespace simgap::reality {

struct CableRig {
  FrictionTruth friction;  ///< its travel > 0; noises and the current's delays are those of logs, not of the rig
  double ratio = 97.74;
  double rotor = 5e-5;        ///< [kg m^2]
  double stiffness = 1500.0;  ///< [N m/rad] of the joint
  double hardening = 0.0;     ///< [N m/rad^3]
  double damping = 3.0;       ///< [N m s/rad]
  double inertia = 0.45;      ///< [kg m^2] about the joint
  double weight = 9.81;       ///< [N m] of the lever when it is level
  double air = 0.2;           ///< [N m s/rad]
  double encoder_step = 0.0;  ///< [rad] of the motor
};

struct CableRigRecord {
  std::vector<double> time, joint, motor, current, torque;  ///< [s], [rad], [rad], [A], [N m] in the cable
};

/// The rig from rest at an angle of the joint. \param current  asked for at every tick: of the time [s] and the
/// encoder's angle [rad] \param tick [s]
CableRigRecord playCableRig(const CableRig& rig, double joint, double seconds, double tick,
                            const std::function<double(double time, double encoder)>& current);

}  // namespace simgap::reality
