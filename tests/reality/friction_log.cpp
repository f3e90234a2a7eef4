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

/// The drive, moved as it is told, and its log.
class CableBench {
 public:
  CableBench(const FrictionTruth& truth, double rate, double ratio, std::mt19937_64& random)
      : truth_(truth), ratio_(ratio), dt_(1.0 / rate), random_(random) {}

  /// \param first  of a session: the current before it is not known
  void record(double angle, double rate, double load, int session, bool first);

  FrictionLog log;

 private:
  double dryFriction(double w, double load);

  const FrictionTruth& truth_;
  double ratio_, dt_;
  std::mt19937_64& random_;
  std::normal_distribution<double> normal_;
  double noise_ = 0.0, deflection_ = 0.0, last_direction_ = 1.0, last_drawn_ = 0.0;
};

double CableBench::dryFriction(double w, double load) {
  const double sliding = truth_.sliding_per_load * std::fabs(load) + truth_.sliding_offset;
  const double breakaway = truth_.breakaway_per_load * std::fabs(load) + truth_.breakaway_offset;
  const double fast = std::pow(std::fabs(w) / truth_.stribeck_velocity, truth_.stribeck_exponent);
  const double level =
      sliding + (breakaway - sliding) * (truth_.fades_hyperbolically ? 1.0 / (1.0 + fast) : std::exp(-fast));
  if (truth_.bristle_travel > 0.0) {
    // dz/dt = w - |w| z / travel, in units of the level: exact for a constant w over the step.
    const double steps = std::fabs(w) * dt_ / truth_.bristle_travel;
    const double target = w > 0.0 ? 1.0 : w < 0.0 ? -1.0 : deflection_;
    deflection_ = target + (deflection_ - target) * std::exp(-steps);
    return level * deflection_;
  }
  if (std::fabs(w) > 1e-9) last_direction_ = w > 0.0 ? 1.0 : -1.0;
  return level * last_direction_;
}

void CableBench::record(double angle, double rate, double load, int session, bool first) {
  const double w = rate * ratio_;
  const double drawn =
      (load + dryFriction(w, load) + truth_.viscous * w) / truth_.torque_per_ampere + truth_.current_offset;
  // Between two samples the current is as good as straight.
  const double late = drawn + truth_.current_late * (first ? 0.0 : last_drawn_ - drawn);
  last_drawn_ = drawn;
  noise_ = truth_.noise_memory * noise_ +
           truth_.noise * std::sqrt(1.0 - truth_.noise_memory * truth_.noise_memory) * normal_(random_);
  log.time.push_back(static_cast<double>(log.time.size()) * dt_);
  log.current.push_back(quantised(late + noise_, truth_.current_grain));
  log.velocity.push_back(w + truth_.velocity_noise * normal_(random_));
  log.position.push_back(angle * ratio_);
  log.load.push_back(truth_.load_noise > 0.0 ? load + truth_.load_noise * normal_(random_) : load);
  log.session.push_back(session);
}

}  // namespace

FrictionLog simulateFrictionLog(const FrictionTruth& truth, const LogDesign& design) {
  std::mt19937_64 random(design.seed);
  std::uniform_real_distribution<double> uniform;
  CableBench drive(truth, design.rate, design.ratio, random);
  const double dt = 1.0 / design.rate;
  for (int session = 0; session < design.sessions; ++session) {
    const double mass_torque = session % 4 == 3 ? 1.0 : 4.0 + (design.heaviest - 4.0) * uniform(random);  // m g l [N m]
    const double inertia = 0.05 * mass_torque;
    Motion motion{0.3 + 0.6 * uniform(random), -0.6 + 1.2 * uniform(random), 0.05 + 0.35 * uniform(random),
                  session % 3 == 2};
    const std::size_t end =
        design.rows * static_cast<std::size_t>(session + 1) / static_cast<std::size_t>(design.sessions);
    for (std::size_t k = 0; drive.log.time.size() < end; ++k) {
      double angle = 0.0, rate = 0.0, acceleration = 0.0;
      motion.at(static_cast<double>(k) * dt, angle, rate, acceleration);
      drive.record(angle, rate, mass_torque * std::sin(angle) + inertia * acceleration, session, k == 0);
    }
  }
  return drive.log;
}

FrictionLog recordMotion(const FrictionTruth& truth, const BenchRun& run, const LogDesign& design) {
  std::mt19937_64 random(design.seed);
  CableBench drive(truth, design.rate, design.ratio, random);
  for (std::size_t i = 0; i < run.angle.size(); ++i) {
    const bool first = i == 0 || run.session[i] != run.session[i - 1];
    drive.record(run.angle[i], run.rate[i], run.load[i], run.session[i], first);
  }
  return drive.log;
}

std::string FrictionLog::csv(bool with_position) const {
  std::vector<std::string> header{"time_s", "motor_current_A", "motor_velocity_rad_s", "external_torque_Nm", "session"};
  if (with_position) header.emplace_back("motor_position_rad");
  CsvWriter writer(header);
  for (std::size_t i = 0; i < time.size(); ++i) {
    writer.add(time[i]).add(current[i]).add(velocity[i]).add(load[i]).add(static_cast<double>(session[i]));
    if (with_position) writer.add(position[i]);
    writer.endRow();
  }
  return writer.text();
}

}  // namespace simgap::reality
