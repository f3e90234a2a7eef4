/// \file
/// A joint that two braided muscles and a motor turn, by other means than the models': force from the virtual work of
/// the braided cylinder, tendons by bisection, bristles solved exactly within a step, semi-implicit Euler with small
/// steps.
#pragma once

#include <array>
#include <cstdint>
#include <functional>
#include <string>
#include <vector>

namespace simgap::reality {

struct ExoRig {
  double diameter = 0.030, braid_angle = 0.436332312998582;  ///< [m], [rad] (25 deg)
  double tendon = 4e4;                                       ///< [N] per unit of contraction
  double length = 0.25, radius = 0.04, rest = 0.12;          ///< [m], [m], contraction of both at angle 0
  double hysteresis = 5e-5, slip = 0.005;
  double supply = 6e5, valve_time = 0.04;
  double inertia = 3.504, weight = 78.48, hangs_at = 0.0;  ///< the rotor behind its gear included
  double coulomb = 0.4, viscous = 8.0;
  double motor_gain = 0.9;  ///< [N m/A]
};

/// References of both valves [Pa], motor current [A], torque from outside [N m].
using ExoRigInputs = std::function<std::array<double, 4>(double time)>;

struct ExoRigRecord {
  std::vector<double> time, angle, flexor_pressure, extensor_pressure, torque;  ///< torque: of the muscles
  /// A log as a rig would write it, with noise of its sensors.
  std::string csv(double noise_Nm, double noise_rad, double noise_Pa, std::uint64_t seed) const;
};

/// Force of a muscle with its tendon. [N]
double exoMuscleForce(const ExoRig& rig, double pressure, double contraction);
/// The rest of the joint's friction is bristles that slip over a milliradian. \param rate  of the record [Hz]
ExoRigRecord recordExoRig(const ExoRig& rig, const ExoRigInputs& inputs, double duration, double rate, double step);

}  // namespace simgap::reality
