/// \file
/// A servo that holds a length, or a joint's angle, with a stiffness of its own: position control without an integral
/// part, whatever it acts on. Parameters: stiffness, offset, damping.
#pragma once

#include "simgap/model/arm/tendon_kind.h"

namespace simgap::tendon_kinds {

/// V = stiffness/2 (q - target - offset)^2
inline TendonPull servoPull(const TendonParameters& p, double q, double target) {
  const double off = q - target - p[1];
  return {0.5 * p[0] * off * off, p[0] * off, p[0], {off, -p[0]}, -p[0]};
}

inline double servoForce(const TendonParameters& p, double q, double rate, double target) {
  return p[0] * (q - target - p[1]) + p[2] * rate;
}

}  // namespace simgap::tendon_kinds
