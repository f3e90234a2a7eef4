#include "reality/friction_log.h"

#include <cmath>
#include <numbers>
#include <random>

#include "reality/measuring_chain.h"
#include "simgap/core/csv.h"

namespace simgap::reality {
namespace {

/// Joint angle of a session, and its first two derivatives.
struct Motion {
  double amplitude, offset, frequency;
  bool steps;

  void at(double t, double& angle, double& rate, double& acceleration) const {
    const double w = 2.0 * std::numbers::pi * frequency;
    if (!steps) {
      angle = offset + amplitude * std::sin(w * t);
      rate = amplitude * w * std::cos(w * t);
      acceleration = -amplitude * w * w * std::sin(w * t);
      return;
    }
    // Forth and back by a smooth ramp with a rest after each; the ramp is 10 s^3 - 15 s^4 + 6 s^5.
    const double half = 0.5 / frequency, move = 0.45 * half;
    const double phase = std::fmod(t, 2.0 * half);
    const double s = std::fmin(std::fmod(phase, half) / move, 1.0);
    const double sign = phase < half ? 1.0 : -1.0;
    const double p = s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
    const double dp = 30.0 * s * s * (1.0 - s) * (1.0 - s) / move;
    const double ddp = 60.0 * s * (1.0 - s) * (1.0 - 2.0 * s) / (move * move);
    angle = offset + amplitude * sign * (2.0 * p - 1.0);
    rate = 2.0 * amplitude * sign * dp;
    acceleration = 2.0 * amplitude * sign * ddp;
  }
};

}  // namespace

FrictionLog simulateFrictionLog(const FrictionTruth& truth, const LogDesign& design) {
  std::mt19937_64 random(design.seed);
  std::normal_distribution<double> normal;
  std::uniform_real_distribution<double> uniform;
  FrictionLog log;
  double noise = 0.0, deflection = 0.0, last_direction = 1.0, last_drawn = 0.0;
  const double dt = 1.0 / design.rate;
  for (int session = 0; session < design.sessions; ++session) {
    const double mass_torque = session % 4 == 3 ? 1.0 : 4.0 + 14.0 * uniform(random);  // m g l [N m]
    const double inertia = 0.05 * mass_torque;
    Motion motion{0.3 + 0.6 * uniform(random), -0.6 + 1.2 * uniform(random), 0.05 + 0.35 * uniform(random),
                  session % 3 == 2};
    const std::size_t end =
        design.rows * static_cast<std::size_t>(session + 1) / static_cast<std::size_t>(design.sessions);
    for (std::size_t k = 0; log.time.size() < end; ++k) {
      double angle = 0.0, rate = 0.0, acceleration = 0.0;
      motion.at(static_cast<double>(k) * dt, angle, rate, acceleration);
      const double w = rate * design.ratio;
      const double load = mass_torque * std::sin(angle) + inertia * acceleration;
      const double sliding = truth.sliding_per_load * std::fabs(load) + truth.sliding_offset;
      const double breakaway = truth.breakaway_per_load * std::fabs(load) + truth.breakaway_offset;
      const double level = sliding + (breakaway - sliding) * std::exp(-std::pow(std::fabs(w) / truth.stribeck_velocity,
                                                                                truth.stribeck_exponent));
      double dry = 0.0;
      if (truth.bristle_travel > 0.0) {
        // dz/dt = w - |w| z / travel, in units of the level: exact for a constant w over the step.
        const double steps = std::fabs(w) * dt / truth.bristle_travel;
        const double target = w > 0.0 ? 1.0 : w < 0.0 ? -1.0 : deflection;
        deflection = target + (deflection - target) * std::exp(-steps);
        dry = level * deflection;
      } else {
        if (std::fabs(w) > 1e-9) last_direction = w > 0.0 ? 1.0 : -1.0;
        dry = level * last_direction;
      }
      const double drawn = (load + dry + truth.viscous * w) / truth.torque_per_ampere + truth.current_offset;
      // Between two samples the current is as good as straight.
      const double late = drawn + truth.current_late * (k == 0 ? 0.0 : last_drawn - drawn);
      last_drawn = drawn;
      noise = truth.noise_memory * noise +
              truth.noise * std::sqrt(1.0 - truth.noise_memory * truth.noise_memory) * normal(random);
      log.time.push_back(static_cast<double>(log.time.size()) * dt);
      log.current.push_back(quantised(late + noise, truth.current_grain));
      log.velocity.push_back(w + truth.velocity_noise * normal(random));
      log.position.push_back(angle * design.ratio);
      log.load.push_back(load);
      log.session.push_back(session);
    }
  }
  return log;
}

std::string FrictionLog::csv() const {
  CsvWriter writer({"time_s", "motor_current_A", "motor_velocity_rad_s", "external_torque_Nm", "session"});
  for (std::size_t i = 0; i < time.size(); ++i) {
    writer.add(time[i]).add(current[i]).add(velocity[i]).add(load[i]).add(static_cast<double>(session[i])).endRow();
  }
  return writer.text();
}

}  // namespace simgap::reality
