#include "simgap/simulate/drive_response.h"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>

#include "simgap/simulate/drive.h"

namespace simgap {
namespace {

constexpr int kSubsteps =
    32;  // of a step within which the rotor starts, stops or turns: the Coulomb torque switches there
constexpr double kStepGrain = 2e-3;  // steps that differ by less than this share of their mean are one step

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
    if (std::signbit(next) == std::signbit(velocity)) return next;
    // What is left of the step begins at rest.
    return step(0.0, current, load, dt * next / (next - velocity));
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

/// Steps of a drive whose winding is fed with a voltage.
class VoltageFed {
 public:
  /// \param ends  of the parts of a step, as shares of it.
  VoltageFed(const MotorLog& log, const Motor& motor, const Gearbox& gearbox, const std::array<double, 3>& ends,
             double grain)
      : load_(log.load), motor_(motor), gearbox_(gearbox), ends_(ends), grain_(grain) {}

  /// One part of a step of `dt`; in finer steps where the rotor starts, stops or turns.
  void advance(DriveState& state, std::size_t part, double dt, double voltage, std::size_t row) {
    const double load = at(load_, row);
    const Part& drive = partsOf(dt)[part];
    DriveState next = state;
    drive.whole.stepThrough(next, voltage, load);
    if (!switches(state.motor_velocity, next.motor_velocity)) {
      state = next;
      return;
    }
    for (int k = 0; k < kSubsteps; ++k) drive.fine.stepThrough(state, voltage, load);
  }

 private:
  struct Part {
    Drive whole, fine;
  };

  const std::array<Part, 3>& partsOf(double dt) {
    const long step = std::lround(dt / grain_);
    auto found = parts_.find(step);
    if (found != parts_.end()) return found->second;
    const double seconds = static_cast<double>(step) * grain_;
    const auto part = [&](double from, double to) {
      return Part{{motor_, gearbox_, (to - from) * seconds}, {motor_, gearbox_, (to - from) * seconds / kSubsteps}};
    };
    return parts_.emplace(step, std::array{part(0.0, ends_[0]), part(ends_[0], ends_[1]), part(ends_[1], ends_[2])})
        .first->second;
  }

  const std::vector<double>& load_;
  const Motor& motor_;
  const Gearbox& gearbox_;
  std::array<double, 3> ends_;
  double grain_;
  std::map<long, std::array<Part, 3>> parts_;
};

/// Steps of a drive whose current is given.
class CurrentFed {
 public:
  CurrentFed(const MotorLog& log, const Motor& motor, const Gearbox& gearbox, const std::array<double, 3>& ends)
      : load_(log.load), rotor_(motor, gearbox), ends_(ends) {}

  void advance(DriveState& state, std::size_t part, double dt, double current, std::size_t row) const {
    const double load = at(load_, row);
    const double seconds = dt * (ends_[part] - (part > 0 ? ends_[part - 1] : 0.0));
    const double next = rotor_.step(state.motor_velocity, current, load, seconds);
    const int steps = switches(state.motor_velocity, next) ? kSubsteps : 1;
    for (int k = 0; k < steps; ++k) {
      state.motor_velocity = rotor_.step(state.motor_velocity, current, load, seconds / steps);
    }
    state.current = current;
  }

 private:
  const std::vector<double>& load_;
  DrivenRotor rotor_;
  std::array<double, 3> ends_;
};

/// Steps of a winding whose voltage and velocity are given: exact for a velocity that is straight between two rows.
/// Where it bends there within L / R, L comes out some per cent small.
class WindingFed {
 public:
  WindingFed(const MotorLog& log, const Motor& motor, const std::array<double, 3>& ends)
      : velocity_(log.velocity), motor_(motor), lag_(motor.inductance / motor.resistance), ends_(ends) {}

  void advance(DriveState& state, std::size_t part, double dt, double voltage, std::size_t row) const {
    const double begin = dt * (part > 0 ? ends_[part - 1] : 0.0), end = dt * ends_[part];
    const double slope = (velocity_[row + 1] - velocity_[row]) / dt;
    const auto velocity = [&](double seconds) { return velocity_[row] + slope * seconds; };
    // What the current tends to: that of the velocity one time constant before.
    const auto settled = [&](double seconds) {
      return (voltage - motor_.back_emf_constant * velocity(seconds - lag_)) / motor_.resistance;
    };
    state.current = settled(end) + (state.current - settled(begin)) * std::exp((begin - end) / lag_);
    state.motor_velocity = velocity(end);
  }

 private:
  const std::vector<double>& velocity_;
  const Motor& motor_;
  double lag_;  ///< L / R
  std::array<double, 3> ends_;
};

/// A delay in rows: so many whole ones, and the share of a step at which the next row's instant lies.
struct Shift {
  explicit Shift(double rows)
      : whole(static_cast<std::ptrdiff_t>(std::floor(rows))), at(1.0 - (rows - std::floor(rows))) {}
  std::ptrdiff_t whole;
  double at;  ///< in (0, 1]
};

/// Goes through a session's steps: in each the input changes once, and the current is sampled once.
template <typename Fed>
void followSession(Fed fed, const MotorLog& log, const Block& rows, const std::vector<double>& input,
                   const Shift& change, const Shift& sample, const std::array<double, 3>& ends,
                   std::span<double> current, std::span<double> velocity) {
  const std::ptrdiff_t count = std::ssize(velocity);
  const auto inputAt = [&](std::ptrdiff_t row) {
    return input[rows.begin + std::clamp<std::ptrdiff_t>(row, 0, count - 1)];
  };
  DriveState state;
  state.current = at(log.current, rows.begin);
  state.motor_velocity = at(log.velocity, rows.begin);
  double sampled = state.current;
  std::ptrdiff_t next = 0;  // row whose current comes next
  for (std::ptrdiff_t i = 0; i < count; ++i) {
    velocity[i] = state.motor_velocity;
    if (i + 1 == count) break;
    const std::size_t row = rows.begin + i;
    const double dt = log.time[row + 1] - log.time[row];
    for (std::size_t part = 0; part < ends.size(); ++part) {
      const double begin = part > 0 ? ends[part - 1] : 0.0;
      if (ends[part] > begin) {
        const std::ptrdiff_t of_input = i + change.whole + (begin >= change.at ? 1 : 0);
        fed.advance(state, part, dt, inputAt(of_input), row);
      }
      if (ends[part] != sample.at) continue;
      for (; next < std::min(count, i + 1 + sample.whole); ++next) current[next] = sampled;
      sampled = state.current;
    }
  }
  for (; next < count; ++next) current[next] = sampled;
}

}  // namespace

void simulateSession(const MotorLog& log, const Block& rows, const Motor& motor, const Gearbox& gearbox,
                     const DriveDelays& delays, DriveExtent extent, std::span<double> current,
                     std::span<double> velocity) {
  const bool has_voltage = !log.voltage.empty();
  const Shift change(delays.input), sample(has_voltage ? delays.current : 0.0);
  const std::array<double, 3> ends = {std::min(change.at, sample.at), std::max(change.at, sample.at), 1.0};
  if (extent == DriveExtent::kWinding) {
    followSession(WindingFed(log, motor, ends), log, rows, log.voltage, change, sample, ends, current, velocity);
  } else if (has_voltage) {
    const double grain =
        kStepGrain * (log.time[rows.end - 1] - log.time[rows.begin]) / static_cast<double>(rows.size());
    followSession(VoltageFed(log, motor, gearbox, ends, grain), log, rows, log.voltage, change, sample, ends, current,
                  velocity);
  } else {
    followSession(CurrentFed(log, motor, gearbox, ends), log, rows, log.current, change, sample, ends, current,
                  velocity);
    std::ranges::copy(std::span(log.current).subspan(rows.begin, rows.size()), current.begin());
  }
}

DriveResponse simulateDrive(const MotorLog& log, const Motor& motor, const Gearbox& gearbox, const DriveDelays& delays,
                            DriveExtent extent) {
  DriveResponse response{std::vector<double>(log.rows()), std::vector<double>(log.rows())};
  for (const Block& rows : splitRows(log.session, log.rows())) {
    simulateSession(log, rows, motor, gearbox, delays, extent,
                    std::span(response.current).subspan(rows.begin, rows.size()),
                    std::span(response.velocity).subspan(rows.begin, rows.size()));
  }
  return response;
}

}  // namespace simgap
