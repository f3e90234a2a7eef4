/// \file
/// A pneumatic muscle on a rig: force from the virtual work of a braided cylinder (volume against length), its tendon
/// solved by bisection, braid friction as a bristle that is dragged along.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace simgap::reality {

struct PamTruth {
  double rest_length = 0.22;      ///< [m]
  double rest_diameter = 0.020;   ///< [m]
  double braid_angle = 0.44;      ///< [rad] at rest
  double tendon = 0.0;            ///< [N] per unit of contraction; 0: rigid
  double tendon_hardening = 0.0;  ///< [1/N] the tendon's stiffness grows with force
  double bladder = 0.0;           ///< [Pa] that the bladder takes up
  double sensor_offset = 0.0;     ///< [Pa] the pressure sensor reads too much
  double force_offset = 0.0;      ///< [N] likewise
  double braid_friction = 0.0;    ///< [m^2] force per pressure
  double ends = 0.0;              ///< share by which contraction counts more, without pressure
  double ends_pressure = 1.2e5;   ///< [Pa] over which that goes
  double wall = 0.0;              ///< [N] stiffness of the rubber tube inside, without pressure
  double drag = 0.0;              ///< [N] of rubber that is pulled at 0.05/s, less than in proportion to the rate
  double creep = 0.0;             ///< share of a change of force that dies away …
  double creep_seconds = 4.0;     ///< … within that time
  double creep_log = 0.0;         ///< share that dies away per factor e of the time since a change, 20 ms to 60 s
  double hose_seconds = 0.0;      ///< the sensor sits before a hose through which the muscle fills and empties
  double breathing = 0.0;         ///< a cause without a name: force swings with humidity
};

struct PamDesign {
  int sessions = 6;
  std::size_t rows = 1200;  ///< per session
  double rate = 50.0;       ///< [Hz]
  double force_noise = 5.0, pressure_noise = 300.0, contraction_noise = 2e-4;
  double noise_memory = 0.0;                       ///< correlation of neighbouring samples' noise of the force
  double pressure_late = 0.0;                      ///< [rows] that the pressure is logged after it was
  double pressure_grain = 0.0, force_grain = 0.0;  ///< [Pa], [N] of the converters
  std::uint64_t seed = 1;
};

struct PamRecord {
  std::vector<double> time, pressure, contraction, force, humidity;
  std::vector<int> session;
  std::string csv() const;
};

PamRecord recordPam(const PamTruth& truth, const PamDesign& design);

}  // namespace simgap::reality
