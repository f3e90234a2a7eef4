#include "reality/exo_joint_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "simgap/core/csv.h"

namespace simgap::reality {
namespace {

/// Of a cylinder whose girth is what a thread of fixed length leaves at that length. [m^3]
double cylinderVolume(double length, double thread, double turns) {
  const double girth = std::sqrt(std::max(thread * thread - length * length, 0.0)) / turns;
  return girth * girth * length / (4.0 * std::numbers::pi);
}

/// -p dV/dl, of any length: force does not depend on it.
double braidPull(const ExoRig& rig, double pressure, double contraction) {
  constexpr double kLength = 1.0, kAside = 1e-5;
  const double thread = kLength / std::cos(rig.braid_angle);
  const double turns = kLength * std::tan(rig.braid_angle) / (std::numbers::pi * rig.diameter);
  const double length = kLength * (1.0 - contraction);
  return -pressure * (cylinderVolume(length + kAside, thread, turns) - cylinderVolume(length - kAside, thread, turns)) /
         (2.0 * kAside);
}

/// A bristle after it was dragged by `way`: exact for a way in one direction.
double dragged(double bent, double way, double slip) {
  const double direction = way < 0.0 ? -1.0 : 1.0;
  return direction + (bent - direction) * std::exp(-std::abs(way) / slip);
}

}  // namespace

double exoMuscleForce(const ExoRig& rig, double pressure, double contraction) {
  if (pressure <= 0.0 || braidPull(rig, pressure, contraction) <= 0.0) return 0.0;
  double low = 0.0, high = braidPull(rig, pressure, contraction);
  for (int i = 0; i < 40; ++i) {
    const double middle = 0.5 * (low + high);
    (braidPull(rig, pressure, contraction + middle / rig.tendon) > middle ? low : high) = middle;
  }
  return 0.5 * (low + high);
}

ExoRigRecord recordExoRig(const ExoRig& rig, const ExoRigInputs& inputs, double duration, double rate, double step) {
  constexpr double kDrySlip = 1e-3;
  double angle = rig.hangs_at, velocity = 0.0, flexor = 0.0, extensor = 0.0;
  double flexor_bent = 0.0, extensor_bent = 0.0, dry_bent = 0.0;
  ExoRigRecord record;
  const auto steps = static_cast<long>(std::llround(duration / step));
  const auto every = static_cast<long>(std::llround(1.0 / (rate * step)));
  for (long i = 0; i <= steps; ++i) {
    const double time = static_cast<double>(i) * step;
    const std::array<double, 4> in = inputs(time);
    const double e = rig.radius * angle / rig.length;
    const double pull =
        std::max(0.0, exoMuscleForce(rig, flexor, rig.rest + e) - rig.hysteresis * flexor * flexor_bent);
    const double back =
        std::max(0.0, exoMuscleForce(rig, extensor, rig.rest - e) - rig.hysteresis * extensor * extensor_bent);
    const double torque = (pull - back) * rig.radius;
    if (i % every == 0) {
      record.time.push_back(time);
      record.angle.push_back(angle);
      record.flexor_pressure.push_back(flexor);
      record.extensor_pressure.push_back(extensor);
      record.torque.push_back(torque);
    }
    const double accelerating = torque + rig.motor_gain * in[2] + in[3] - rig.weight * std::sin(angle - rig.hangs_at) -
                                rig.viscous * velocity - rig.coulomb * dry_bent;
    velocity += accelerating / rig.inertia * step;
    const double moved = velocity * step;
    angle += moved;
    flexor_bent = dragged(flexor_bent, moved * rig.radius / rig.length, rig.slip);
    extensor_bent = dragged(extensor_bent, -moved * rig.radius / rig.length, rig.slip);
    dry_bent = dragged(dry_bent, moved, kDrySlip);
    const double filled = 1.0 - std::exp(-step / rig.valve_time);
    flexor += (std::clamp(in[0], 0.0, rig.supply) - flexor) * filled;
    extensor += (std::clamp(in[1], 0.0, rig.supply) - extensor) * filled;
  }
  return record;
}

std::string ExoRigRecord::csv(double noise_Nm, double noise_rad, double noise_Pa, std::uint64_t seed) const {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  CsvWriter writer({"time_s", "angle_rad", "pressure_flexor_Pa", "pressure_extensor_Pa", "muscle_torque_Nm"});
  const auto rounded = [](double value, double grain) { return grain * std::round(value / grain); };
  for (std::size_t i = 0; i < time.size(); ++i) {
    writer.add(time[i]).add(rounded(angle[i] + noise_rad * normal(random), 1e-5));
    writer.add(rounded(flexor_pressure[i] + noise_Pa * normal(random), 1.0));
    writer.add(rounded(extensor_pressure[i] + noise_Pa * normal(random), 1.0));
    writer.add(rounded(torque[i] + noise_Nm * normal(random), 1e-4)).endRow();
  }
  return writer.text();
}

}  // namespace simgap::reality
