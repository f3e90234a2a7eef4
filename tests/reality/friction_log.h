/// \file
/// Logs of a cable-driven joint as 003 measured them, from equations of their own: friction is evaluated sample by
/// sample, or comes from bristles integrated in time (LuGre: Canudas de Wit et al. 1995).
#pragma once

#include <cstdint>
#include <string>
#include <vector>

namespace simgap::reality {

struct FrictionTruth {
  double torque_per_ampere = 1.3;   ///< [N m/A]
  double sliding_per_load = 0.25;   ///< [1]
  double sliding_offset = 0.0;      ///< [N m]
  double breakaway_per_load = 0.4;  ///< [1]
  double breakaway_offset = 0.0;    ///< [N m]
  double viscous = 0.012;           ///< [N m s/rad] of the motor
  double stribeck_velocity = 12.0;  ///< [rad/s] of the motor
  double stribeck_exponent = 1.2;
  double current_offset = 0.0;  ///< [A]
  double noise = 0.25;          ///< [A] standard deviation of the current's noise
  double noise_memory = 0.0;    ///< correlation of neighbouring samples' noise
  double velocity_noise = 0.0;  ///< [rad/s]
  double current_late = 0.0;    ///< [rows] that the current is logged after it flowed; without bristles
  double current_grain = 0.0;   ///< [A] of the converter
  double bristle_travel = 0.0;  ///< [rad] of the motor until friction has built up; 0: none
};

struct LogDesign {
  std::size_t rows = 5000;
  double rate = 50.0;  ///< [Hz]
  int sessions = 10;
  double ratio = 97.74;  ///< motor per joint
  std::uint64_t seed = 1;
};

struct FrictionLog {
  std::vector<double> time, current, velocity, position, load;
  std::vector<int> session;
  std::string csv() const;
};

/// Sinusoids with different offsets and loads, and in every third session steps with rests; up to about 20 N m and
/// 140 deg/s at the joint.
FrictionLog simulateFrictionLog(const FrictionTruth& truth, const LogDesign& design);

}  // namespace simgap::reality
