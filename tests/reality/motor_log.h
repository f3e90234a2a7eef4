/// \file
/// A DC motor, with or without a gearbox, on a bench: its equations integrated in fine steps.
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace simgap::reality {

struct MotorTruth {
  double resistance = 0.8, inductance = 4e-3, emf = 0.021, torque = 0.021;
  double inertia = 6e-6, viscous = 2e-6, coulomb = 0.002;
  double ratio = 1.0, efficiency = 1.0, gear_coulomb = 0.0, gear_viscous = 0.0, gear_inertia = 0.0;
  double brush_drop = 0.0;                      ///< [V] of carbon on copper, half of it at 0.2 A
  double heating = 0.0, heating_seconds = 20.;  ///< relative rise of the resistance at 2 A for long
  double load_loss = 0.0;                       ///< share of the load's torque that the teeth take, either way
  double ripple = 0.0, ripple_turns = 2.0;      ///< [N m] at the output, so often per turn of the rotor
  double current_offset = 0.0;                  ///< [A] that the sensor reads too much
  double play = 0.0;                            ///< [rad] of the rotor between the teeth
  double bristle_travel = 0.0;                  ///< [rad] of the rotor in which dry friction builds up; 0: at once
};

struct MotorDesign {
  double seconds = 6.0;
  double rate = 1000.0;  ///< [Hz] of the log
  int sessions = 2;
  double load = 0.01;           ///< [N m] amplitude of the load steps at the output
  double voltage = 12.0;        ///< [V] amplitude of the voltage steps
  double current_noise = 0.0;   ///< [A]
  double velocity_noise = 0.0;  ///< [rad/s]
  double noise_memory = 0.0;    ///< correlation of neighbouring samples' noise
  double voltage_late = 0.0;    ///< [rows] that the voltage is logged after it was
  double current_late = 0.0;    ///< [rows] likewise
  double voltage_grain = 0.0, current_grain = 0.0, velocity_grain = 0.0;  ///< [V], [A], [rad/s] of the converters
  double step = 2e-5;                                                     ///< [s] of the integration
  std::uint64_t seed = 1;
};

struct MotorBenchLog {
  std::vector<double> time, voltage, current, velocity, load;
  std::vector<int> session;
  /// Columns by name; leave out what the log shall lack.
  std::string csv(bool with_voltage = true, bool with_load = true, bool with_velocity = true) const;
};

/// Steps of voltage and, unsynchronised with them, of load.
MotorBenchLog simulateMotor(const MotorTruth& truth, const MotorDesign& design);

}  // namespace simgap::reality
