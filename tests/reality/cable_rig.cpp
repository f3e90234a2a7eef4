#include "reality/cable_rig.h"

#include <array>
#include <cmath>

namespace simgap::reality {
namespace {

/// Joint, its rate, motor, its rate, bent bristles in parts of their travel.
using RigState = std::array<double, 5>;

double pullOf(const CableRig& rig, const RigState& s) {
  const double stretch = s[2] / rig.ratio - s[0];
  return rig.stiffness * stretch + rig.hardening * stretch * stretch * stretch +
         rig.damping * (s[3] / rig.ratio - s[1]);
}

RigState slope(const CableRig& rig, const RigState& s, double current) {
  const FrictionTruth& f = rig.friction;
  const double pull = pullOf(rig, s), size = std::fabs(pull), w = s[3];
  const double sliding = f.sliding_per_load * size + f.sliding_offset;
  const double breakaway = f.breakaway_per_load * size + f.breakaway_offset;
  const double level =
      sliding + (breakaway - sliding) / (1.0 + std::pow(std::fabs(w) / f.stribeck_velocity, f.stribeck_exponent));
  const double bending = (w - std::fabs(w) * s[4]) / f.bristle_travel;
  constexpr double kBristleDamping = 2e-3;  // [s]
  const double held = level * (s[4] + kBristleDamping * bending) + f.viscous * w;
  const double driven = f.torque_per_ampere * (current - f.current_offset);
  return {s[1], (pull - rig.weight * std::sin(s[0]) - rig.air * s[1]) / rig.inertia, w,
          (driven - pull - held) / (rig.ratio * rig.rotor), bending};
}

RigState moved(const RigState& s, const RigState& along, double by) {
  RigState result;
  for (std::size_t i = 0; i < s.size(); ++i) result[i] = s[i] + by * along[i];
  return result;
}

}  // namespace

CableRigRecord playCableRig(const CableRig& rig, double joint, double seconds, double tick,
                            const std::function<double(double time, double encoder)>& current) {
  constexpr double kLargestStep = 2e-5;  // [s]: bristles of 0.02 rad at 200 rad/s turn round in 1e-4
  const int steps = static_cast<int>(std::ceil(tick / kLargestStep));
  const double h = tick / steps;
  // The cable carries the lever, and the bristles nothing yet.
  double stretch = 0.0;
  for (int i = 0; i < 60; ++i) {
    stretch = (rig.weight * std::sin(joint)) / (rig.stiffness + rig.hardening * stretch * stretch);
  }
  RigState s{joint, 0.0, rig.ratio * (joint + stretch), 0.0, 0.0};
  CableRigRecord record;
  for (long k = 0; static_cast<double>(k) * tick <= seconds; ++k) {
    const double seen = rig.encoder_step > 0.0 ? rig.encoder_step * std::round(s[2] / rig.encoder_step) : s[2];
    const double drawn = current(static_cast<double>(k) * tick, seen);
    record.time.push_back(static_cast<double>(k) * tick);
    record.joint.push_back(s[0]);
    record.motor.push_back(s[2]);
    record.current.push_back(drawn);
    record.torque.push_back(pullOf(rig, s));
    for (int i = 0; i < steps; ++i) {
      const RigState a = slope(rig, s, drawn), b = slope(rig, moved(s, a, 0.5 * h), drawn);
      const RigState c = slope(rig, moved(s, b, 0.5 * h), drawn), d = slope(rig, moved(s, c, h), drawn);
      for (std::size_t j = 0; j < s.size(); ++j) s[j] += h / 6.0 * (a[j] + 2.0 * b[j] + 2.0 * c[j] + d[j]);
    }
  }
  return record;
}

}  // namespace simgap::reality
