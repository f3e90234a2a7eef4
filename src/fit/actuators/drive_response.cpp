#include "drive_response.h"

#include <cmath>
#include <map>

#include "simgap/simulate/drive.h"

namespace simgap {
namespace {

constexpr int kSubsteps =
    32;  // of a step within which the rotor starts, stops or turns: the Coulomb torque switches there
constexpr double kStepGrain = 2e-3;  // steps that differ by less than this share of the first are one step

bool switches(double before, double after) {
  return before == 0.0 || after == 0.0 || std::signbit(before) != std::signbit(after);
}

double at(const std::vector<double>& channel, std::size_t row) { return channel.empty() ? 0.0 : channel[row]; }

/// The speed of the rotor when its current is given: exact over a step of constant inputs, held at rest by the Coulomb
/// torque up to its limit.
class DrivenRotor {
 public:
  DrivenRotor(const Motor& motor, const Gearbox& gearbox)
      : gain_(gearbox.ratio * gearbox.efficiency),
        inertia_(gain_ * motor.inertia + gearbox.inertia / gearbox.ratio),
        damping_(gain_ * motor.viscous_friction + gearbox.viscous_friction / gearbox.ratio),
        coulomb_(gain_ * motor.coulomb_friction + gearbox.coulomb_friction),
        per_ampere_(gain_ * motor.torque_constant) {}

  double step(double velocity, double current, double load, double dt) const {
    const double driving = per_ampere_ * current - load;
    if (velocity == 0.0) {
      if (std::abs(driving) <= coulomb_) return 0.0;
      return move(0.0, driving - std::copysign(coulomb_, driving), dt);
    }
    const double next = move(velocity, driving - std::copysign(coulomb_, velocity), dt);
    return std::signbit(next) == std::signbit(velocity) ? next : 0.0;
  }

 private:
  double move(double velocity, double torque, double dt) const {
    const double decay = damping_ * dt / inertia_;
    // (1 - exp(-x)) / x, which is 1 without damping.
    const double share = decay > 1e-9 ? -std::expm1(-decay) / decay : 1.0;
    return velocity * std::exp(-decay) + torque * dt / inertia_ * share;
  }

  double gain_, inertia_, damping_, coulomb_, per_ampere_;
};

}  // namespace

void simulateSession(const MotorLog& log, const Block& rows, const Motor& motor, const Gearbox& gearbox,
                     std::span<double> current, std::span<double> velocity) {
  const std::size_t first = rows.begin;
  if (log.voltage.empty()) {
    const DrivenRotor rotor(motor, gearbox);
    double speed = at(log.velocity, first);
    for (std::size_t i = first; i < rows.end; ++i) {
      current[i - first] = log.current[i];
      velocity[i - first] = speed;
      if (i + 1 == rows.end) break;
      const double dt = log.time[i + 1] - log.time[i];
      const double next = rotor.step(speed, log.current[i], at(log.load, i), dt);
      const int steps = switches(speed, next) ? kSubsteps : 1;
      if (steps == 1) speed = next;
      for (int k = 0; steps > 1 && k < steps; ++k)
        speed = rotor.step(speed, log.current[i], at(log.load, i), dt / steps);
    }
    return;
  }
  const double grain = kStepGrain * (log.time[rows.end - 1] - log.time[first]) / static_cast<double>(rows.size());
  struct Steps {
    Drive whole, part;
  };
  std::map<long, Steps> drives;
  DriveState state;
  state.current = at(log.current, first);
  state.motor_velocity = at(log.velocity, first);
  for (std::size_t i = first; i < rows.end; ++i) {
    current[i - first] = state.current;
    velocity[i - first] = state.motor_velocity;
    if (i + 1 == rows.end) break;
    const long step = std::lround((log.time[i + 1] - log.time[i]) / grain);
    auto found = drives.find(step);
    if (found == drives.end()) {
      const double dt = static_cast<double>(step) * grain;
      found = drives.emplace(step, Steps{{motor, gearbox, dt}, {motor, gearbox, dt / kSubsteps}}).first;
    }
    DriveState next = state;
    found->second.whole.step(next, log.voltage[i], at(log.load, i));
    if (switches(state.motor_velocity, next.motor_velocity)) {
      for (int k = 0; k < kSubsteps; ++k) found->second.part.step(state, log.voltage[i], at(log.load, i));
    } else {
      state = next;
    }
  }
}

DriveResponse simulateDrive(const MotorLog& log, const Motor& motor, const Gearbox& gearbox) {
  DriveResponse response{std::vector<double>(log.rows()), std::vector<double>(log.rows())};
  for (const Block& rows : splitRows(log.session, log.rows())) {
    simulateSession(log, rows, motor, gearbox, std::span(response.current).subspan(rows.begin, rows.size()),
                    std::span(response.velocity).subspan(rows.begin, rows.size()));
  }
  return response;
}

}  // namespace simgap
