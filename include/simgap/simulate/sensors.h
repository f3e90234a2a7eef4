/// \file
/// What a rig would log of a motion (000 section VI): potentiometers, force and current sensors of the muscles, and the
/// joints as a capture sees them, each with its rate, clock, noise and quantisation.
#pragma once

#include <cstdint>
#include <string>

#include "simgap/core/yaml.h"
#include "simgap/simulate/rollout.h"

namespace simgap {

struct SensorNoise {
  double noise = 0.0;         ///< standard deviation, in the sensor's unit
  double quantisation = 0.0;  ///< distance of the values it can give; 0: none
};

/// A clock that reads offset + (1 + drift) t.
struct SensorClock {
  double rate = 100.0;  ///< [Hz]
  double offset = 0.0;  ///< [s]
  double drift = 0.0;   ///< (1)
  double reads(double time) const { return offset + (1.0 + drift) * time; }
};

struct SensorOptions {
  SensorClock muscles;
  SensorNoise shaft;    ///< [rad]
  SensorNoise force;    ///< [N]
  SensorNoise current;  ///< [A]
  SensorClock joints{.rate = 60.0};
  double joint_noise = 0.0;  ///< [rad] of a revolute joint, and of each axis of a spherical one
  double slide_noise = 0.0;  ///< [m]

  /// Reads a `sensors:` section; what is missing keeps its value. \throws ConfigError
  static SensorOptions read(const YamlNode& node);
  std::string toYaml() const;
};

/// Times of a sensor, from start to end. [s] \throws ConfigError: 1e7 of them or more
std::vector<double> sensorTimes(const SensorClock& clock, double start, double end);

/// muscles.csv: `time_s`, the commands, `shaft_<m>_rad`, `current_<m>_A`, `measured_force_<m>_N`.
/// \param track  at sensorTimes(options.muscles, …)
std::string musclesCsv(const ArmModel& model, const MotionCommands& commands, bool with_commands,
                       const MotionTrack& track, const SensorOptions& options, std::uint64_t seed);
/// joints.csv as `capture` writes it: `time_s` and the joints' position columns.
/// \param track  at sensorTimes(options.joints, …)
std::string jointsCsv(const ArmModel& model, const MotionTrack& track, const SensorOptions& options,
                      std::uint64_t seed);

}  // namespace simgap
