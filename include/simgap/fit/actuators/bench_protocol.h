/// \file
/// What to record of one drive on its bench, so that a friction law and its causes are known best: sessions of a
/// sinusoid, or of moves with rests between them, each under one weight on the joint's lever (003 section 4.1 has
/// both). Of many motions within the limits those are taken whose log is expected to determine all parameters together
/// best (D-optimal: Fedorov 1972), for a fit by least squares under noise that remembers:
///
///     covariance = A^-1 B A^-1,   A = sum J^T J,   B = sum J^T Omega J,   Omega_ij = sigma^2 memory^|i - j|
///
/// with the derivatives J of the model's own effort. At rest friction is anywhere between its two static values, so
/// that rows at rest count for nothing.
#pragma once

#include <cstdint>
#include <functional>
#include <string>
#include <vector>

#include "simgap/core/yaml.h"
#include "simgap/model/actuator/fitted_model.h"
#include "simgap/optimize/parameter.h"

namespace simgap {

/// What hangs on the lever of a joint.
struct LeverWeight {
  double mass;    ///< [kg]
  double length;  ///< [m] from the axis
};

/// `simgap/drive-limits/1` (docs/formats.md).
struct DriveLimits {
  double duration = 300.0;           ///< [s] of all sessions
  double session = 20.0;             ///< [s] of one
  double rate = 50.0;                ///< [Hz] of the log
  double ratio = 1.0;                ///< motor per joint
  double lower, upper;               ///< [rad] of the joint
  double velocity, acceleration;     ///< [rad/s], [rad/s^2] of the joint
  double torque;                     ///< [N m] of the load
  double current;                    ///< [A]
  double noise, memory = 0.0;        ///< [A] of the current's rows, and correlation of neighbours
  double hangs = 0.0;                ///< [rad] reading at which the lever hangs down
  std::vector<LeverWeight> weights;  ///< at least one
  FittedModel guess;                 ///< law, values and causes of the drive as far as it is known

  std::size_t sessions() const;
  std::size_t sessionRows() const;

  /// \param fitted  takes the place of the file's `guess`, if it is not null
  /// \throws ConfigError: limits that contradict each other, an unknown law or cause, a model of another effort
  static DriveLimits read(const YamlNode& root, const FittedModel* fitted);
};

/// The motion of a session, from rest at its lower end.
struct BenchMotion {
  enum class Kind {
    kSine,
    kMoves,  ///< forth and back with a trapezoid of velocity, and a rest at either end
  } kind = Kind::kSine;
  double middle, amplitude;  ///< [rad] of the joint
  double speed;              ///< [rad/s] its fastest
  double acceleration;       ///< [rad/s^2] its largest
  double rest = 0.0;         ///< [s]
  std::size_t weight = 0;    ///< of DriveLimits::weights

  struct State {
    double angle, velocity, acceleration;
  };
  State at(double time) const;
};

/// A protocol, and what it is expected to tell.
struct ProtocolPrecision {
  std::vector<Estimate> expected;  ///< shape (P): the values it is for; NaN deviations of what is not determined
  double log_sd = 0.0;             ///< mean logarithm over all directions, each in a unit of its own: what is minimised
};

struct BenchProtocol {
  std::vector<BenchMotion> sessions;
  ProtocolPrecision precision;
  std::vector<ProtocolPrecision> random;  ///< of as many sessions drawn at random from the same motions
  std::size_t drawn = 0, within = 0;      ///< motions drawn, and of those within all limits
  std::vector<std::string> silent;        ///< parameters that no motion within the limits tells anything of
  std::vector<double> time, angle, velocity, acceleration, load, current;  ///< shape (rows) of the log to be recorded
  std::vector<std::size_t> session;                                        ///< shape (rows)
};

/// \param news  called with the share done; \throws ConfigError: limits that leave no motion, or too few to tell the
/// parameters; a cause whose channel a protocol cannot have; InterruptedError
BenchProtocol designProtocol(const DriveLimits& limits, std::uint64_t seed,
                             const std::function<void(double share)>& news);

}  // namespace simgap
