/// \file
/// A geared motor that swings a pendulum through slow and fast motions and holds it still at times: dry friction that
/// falls with speed and holds the joint at rest, an encoder, a current with noise. What a bench of 003's kind logs.
#pragma once

#include <cstdint>
#include <map>
#include <string>

namespace simgap::reality {

struct StickingPendulum {
  double torque_constant = 2.0;          ///< [N m/A] at the joint
  double mass = 1.0, length = 0.25;      ///< [kg], [m]
  double inertia = 0.015;                ///< [kg m^2] besides m l^2
  double dry = 0.5, breakaway = 0.65;    ///< [N m] sliding, from rest
  double falls_over = 0.15;              ///< [rad/s]
  double steepness = 1.3;                ///< of the fall
  double viscous = 0.15;                 ///< [N m s/rad]
  double current_noise = 0.02;           ///< [A]
  double counts = 8192.0;                ///< of the encoder, per turn
  double seconds = 150.0, rate = 100.0;  ///< [Hz]
  bool logs_velocity = false;
  std::uint64_t seed = 1;

  std::string csv() const;
  std::string benchYaml() const;
  /// By the names of fit-friction with the law "stribeck".
  std::map<std::string, double> truth() const;
};

/// A bench of another size and friction for every seed.
StickingPendulum drawStickingPendulum(std::uint64_t seed);

}  // namespace simgap::reality
