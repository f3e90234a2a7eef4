#include "reality/sticking_pendulum.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <numbers>
#include <random>

namespace simgap::reality {
namespace {

constexpr double kGravity = 9.81, kStep = 1e-3;

/// Where the joint is to be: three sines, which stop for a second now and then.
class Course {
 public:
  explicit Course(std::mt19937_64& random) {
    std::uniform_real_distribution<double> amplitude(0.5, 1.3), detuned(0.8, 1.2), turn(0.0, 2.0 * std::numbers::pi);
    constexpr double kFrequencies[] = {0.04, 0.15, 0.4};  // [Hz]
    for (std::size_t k = 0; k < sines_.size(); ++k) {
      sines_[k].amplitude = amplitude(random);
      sines_[k].rate = 2.0 * std::numbers::pi * kFrequencies[k] * detuned(random);
      sines_[k].phase = turn(random);
    }
    every_ = std::uniform_real_distribution<double>(10.0, 14.0)(random);
  }
  double at(double time) const {
    const double stops = std::floor(time / every_), within = time - stops * every_;
    const double moved = stops * (every_ - 1.0) + std::min(within, every_ - 1.0);
    double sum = 0.0;
    for (const Sine& s : sines_) sum += s.amplitude * (std::sin(s.rate * moved + s.phase) - std::sin(s.phase));
    return sum;
  }

 private:
  struct Sine {
    double amplitude, rate, phase;
  };
  std::array<Sine, 3> sines_;
  double every_;
};

}  // namespace

std::string StickingPendulum::csv() const {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal;
  const Course course(random);
  const double whole = mass * length * length + inertia, weight = mass * kGravity * length;
  const auto every = static_cast<long>(std::lround(1.0 / (rate * kStep)));
  double angle = 0.0, speed = 0.0, sum = 0.0;
  std::string text = logs_velocity ? "time_s,motor_current_A,motor_position_rad,motor_velocity_rad_s\n"
                                   : "time_s,motor_current_A,motor_position_rad\n";
  for (long k = 0; static_cast<double>(k) * kStep < seconds; ++k) {
    const double time = static_cast<double>(k) * kStep, error = course.at(time) - angle;
    sum = std::clamp(sum + error * kStep, -0.3, 0.3);
    const double current = whole * (600.0 * error + 600.0 * sum - 30.0 * speed) / torque_constant;
    if (k % every == 0) {
      const double count = 2.0 * std::numbers::pi / counts, measured = current + current_noise * normal(random);
      char row[128];
      std::snprintf(row, sizeof row, "%.6g,%.6g,%.8g", time, measured, count * std::round(angle / count));
      text += row;
      if (logs_velocity) {
        std::snprintf(row, sizeof row, ",%.6g", speed + 2e-3 * normal(random));
        text += row;
      }
      text += "\n";
    }
    const double pull = torque_constant * current - weight * std::sin(angle);
    if (speed == 0.0 && std::abs(pull) <= breakaway) continue;  // friction holds it
    const double side = std::copysign(1.0, speed == 0.0 ? pull : speed);
    const double fall = std::exp(-std::pow(std::abs(speed) / falls_over, steepness));
    const double friction = side * (dry + (breakaway - dry) * fall) + viscous * speed;
    const double next = speed + kStep * (pull - friction) / whole;
    angle += 0.5 * kStep * (speed + next);
    speed = next * side < 0.0 ? 0.0 : next;  // it comes to rest before it turns
  }
  return text;
}

std::string StickingPendulum::benchYaml() const {
  char text[160];
  std::snprintf(text, sizeof text,
                "format: simgap/bench/1\nload: pendulum\nmass_kg: %.9g\nlength_m: %.9g\ninertia_kg_m2: fit\n", mass,
                length);
  return text;
}

std::map<std::string, double> StickingPendulum::truth() const {
  return {{"k_a", torque_constant}, {"tau_c", dry},      {"tau_s", breakaway}, {"k_v", viscous},
          {"inertia", inertia},     {"v_s", falls_over}, {"delta", steepness}};
}

StickingPendulum drawStickingPendulum(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  const auto between = [&](double low, double high) {
    return std::uniform_real_distribution<double>(low, high)(random);
  };
  StickingPendulum bench;
  bench.seed = seed;
  bench.torque_constant = between(1.0, 4.0);
  bench.mass = between(0.5, 1.5);
  bench.length = between(0.15, 0.35);
  bench.inertia = between(0.005, 0.03);
  bench.dry = bench.torque_constant * between(0.1, 0.4);
  bench.breakaway = bench.dry * between(1.15, 1.5);
  bench.falls_over = between(0.1, 0.4);
  bench.steepness = between(0.8, 2.0);
  bench.viscous = bench.torque_constant * between(0.02, 0.15);
  bench.current_noise = between(0.01, 0.03);
  return bench;
}

}  // namespace simgap::reality
