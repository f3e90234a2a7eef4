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
  double load_noise = 0.0;      ///< [N m] of the torque sensor
  double current_late = 0.0;    ///< [rows] that the current is logged after it flowed; without bristles
  double current_grain = 0.0;   ///< [A] of the converter
  double bristle_travel = 0.0;  ///< [rad] of the motor until friction has built up; 0: none
  /// Static friction fades as 1 / (1 + |w / v|^exponent) (Hess & Soom 1990), not as exp(-|w / v|^exponent).
  bool fades_hyperbolically = false;
};

struct LogDesign {
  std::size_t rows = 5000;
  double rate = 50.0;  ///< [Hz]
  int sessions = 10;
  double heaviest = 18.0;  ///< [N m] that the weights pull with when the lever is level; 1 N m in every fourth session
  double ratio = 97.74;    ///< motor per joint
  std::uint64_t seed = 1;
};

struct FrictionLog {
  std::vector<double> time, current, velocity, position, load;
  std::vector<int> session;
  /// \param with_position  motor_position_rad, too
  std::string csv(bool with_position = false) const;
};

/// Sinusoids with different offsets and loads, and in every third session steps with rests; up to about 20 N m and
/// 140 deg/s at the joint.
FrictionLog simulateFrictionLog(const FrictionTruth& truth, const LogDesign& design);

/// What a bench makes the joint do; every vector has shape (rows).
struct BenchRun {
  std::vector<double> angle, rate;  ///< [rad], [rad/s] of the joint
  std::vector<double> load;         ///< [N m]
  std::vector<int> session;
};
/// The same drive moved as it is told. \param design  its rate, ratio and seed
FrictionLog recordMotion(const FrictionTruth& truth, const BenchRun& run, const LogDesign& design);

}  // namespace simgap::reality
