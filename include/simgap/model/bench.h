/// \file
/// The rig a drive was measured on, `format: simgap/bench/1`: where the load torque comes from.
#pragma once

#include <optional>
#include <string>
#include <vector>

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

struct Bench {
  BenchLoad load = BenchLoad::kTorqueSensor;
  BenchConstant mass;               ///< [kg] of the pendulum's bob, or of a linear axis
  BenchConstant inertia;            ///< [kg m^2] besides m l^2
  double length = 0.0;              ///< [m] pendulum
  double angle_offset = 0.0;        ///< [rad] reading at which the pendulum hangs down
  double gravity = 9.81;            ///< [m/s^2]
  std::optional<double> bandwidth;  ///< [Hz] of the smoothing that gives velocity and acceleration
  std::optional<double> ratio;      ///< motor per joint

  bool needsAcceleration() const { return load != BenchLoad::kTorqueSensor; }
};

/// Keys: `load`, `mass_kg`, `inertia_kg_m2` (a number or `fit`), `length_m`, `angle_offset_rad`, `gravity_m_s2`,
/// `bandwidth_Hz`, `transmission_ratio`. \throws ConfigError.
Bench readBench(const YamlNode& root);

}  // namespace simgap
