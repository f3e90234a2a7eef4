/// \file
/// The rig a drive was measured on, `format: simgap/bench/1`: where the load torque comes from.
#pragma once

#include <map>
#include <optional>
#include <string>
#include <vector>

#include "simgap/core/units.h"
#include "simgap/core/yaml.h"

namespace simgap {

enum class BenchLoad {
  kTorqueSensor,  ///< `external_torque_Nm` of the log
  kPendulum,      ///< m g l sin(theta - theta_0) + (m l^2 + J) theta''; theta = 0 hangs down
  kFreeAxis,      ///< J theta'' or m x''
};

/// A constant of the rig: known, or to be fitted.
struct BenchConstant {
  double value = 0.0;
  bool fitted = false;
};

struct BenchConstants {
  BenchConstant mass;          ///< [kg] of the pendulum's bob, or of a linear axis
  BenchConstant inertia;       ///< [kg m^2] besides m l^2; where `fitsWholeInertia`, all of it
  BenchConstant length;        ///< [m] pendulum
  BenchConstant angle_offset;  ///< [rad] reading at which the pendulum hangs down
};

struct Bench : BenchConstants {
  std::string file;  ///< it was read from; empty when there is none
  BenchLoad load = BenchLoad::kTorqueSensor;
  double gravity = kEarthGravity;   ///< [m/s^2]
  std::optional<double> bandwidth;  ///< [Hz] of the smoothing that gives velocity and acceleration
  std::optional<double> ratio;      ///< motor per joint
  /// The constants of each session of a log, where they change from one to the next; empty where they do not. What is
  /// fitted is the same in all of them.
  std::map<std::string, BenchConstants> sessions;

  bool needsAcceleration() const { return load != BenchLoad::kTorqueSensor; }
  /// Where m l is fitted with length or angle, m l^2 cannot be told from the inertia besides it.
  bool fitsWholeInertia() const { return length.fitted || (angle_offset.fitted && mass.fitted); }
  /// A pendulum's mass or length is fitted at an angle offset that was stated.
  bool fitsWeight() const {
    return load == BenchLoad::kPendulum && (mass.fitted || length.fitted) && !angle_offset.fitted;
  }
};

/// Keys: `load`, `mass_kg`, `inertia_kg_m2`, `length_m`, `angle_offset_rad` (each a number or `fit`), `gravity_m_s2`,
/// `bandwidth_Hz`, `transmission_ratio`; `sessions`: name -> numbers that replace some of the first four there.
/// \throws ConfigError.
Bench readBench(const YamlNode& root);

/// What it means when the fit of `fitsWeight` leaves nothing of it. \param constant  "mass" or "length"
std::string weightlessSentence(const std::string& constant);

}  // namespace simgap
