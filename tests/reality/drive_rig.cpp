#include "reality/drive_rig.h"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "simgap/core/csv.h"

namespace simgap::reality {
namespace {

constexpr double kTwoPi = 2.0 * std::numbers::pi;

/// One run: a swing, a staircase of moves and rests, or a slow sweep.
struct Run {
  enum class Kind { kSwing, kStairs, kSweep } kind;
  double amplitude, middle, frequency, weight, weight_angle;
  std::vector<double> goals;  ///< stairs: angles
  double move = 1.0, rest = 4.0;

  double angle(double t) const {
    switch (kind) {
      case Kind::kSwing:
        return middle + amplitude * std::sin(kTwoPi * frequency * t);
      case Kind::kSweep: {
        const double phase = std::fmod(t * frequency, 1.0);
        const double triangle = phase < 0.5 ? 4.0 * phase - 1.0 : 3.0 - 4.0 * phase;
        return middle + amplitude * std::sin(0.5 * std::numbers::pi * triangle);
      }
      case Kind::kStairs: {
        const auto step = static_cast<std::size_t>(t / (move + rest));
        const double from = goals[step % goals.size()], to = goals[(step + 1) % goals.size()];
        const double s = std::min((t - static_cast<double>(step) * (move + rest)) / move, 1.0);
        return from + (to - from) * 0.5 * (1.0 - std::cos(std::numbers::pi * s));
      }
    }
    return 0.0;
  }
};

Run drawRun(std::mt19937_64& random, const DriveRig& rig) {
  std::uniform_real_distribution<double> u;
  Run run{};
  const double kind = u(random);
  run.kind = kind < 0.6 ? Run::Kind::kSwing : kind < 0.85 ? Run::Kind::kStairs : Run::Kind::kSweep;
  run.amplitude = 0.25 + 0.65 * u(random);
  run.middle = -0.7 + 1.4 * u(random);
  run.frequency = run.kind == Run::Kind::kSweep ? 0.02 + 0.03 * u(random) : 0.04 + 0.3 * u(random);
  run.weight = u(random) < 0.25 ? 0.3 * u(random) : rig.largest_load * (0.15 + 0.85 * u(random));
  run.weight_angle = -0.8 + 1.6 * u(random);
  run.move = 0.5 + 1.5 * u(random);
  run.rest = 1.0 + 8.0 * u(random);
  for (int k = 0; k < 6; ++k) run.goals.push_back(run.middle + run.amplitude * (2.0 * u(random) - 1.0));
  return run;
}

/// What the drive feels, before any sensor.
struct Truth {
  DriveRecord record;                 ///< without noise
  std::vector<double> sliding_share;  ///< columns a load-dependent Stribeck law has, for expectedGain
  std::vector<double> acceleration, rest;
};

class Drive {
 public:
  Drive(const DriveRig& rig, const DriveSecret& secret) : rig_(rig), secret_(secret) {}
  Truth run();

 private:
  double frictionAt(double w, double load, double angle, double temperature, double humidity, double vibration,
                    double t);

  const DriveRig& rig_;
  const DriveSecret& secret_;
  double bristle_ = 0.0;  ///< deflection in travels, -1 to 1
  double rested_ = 0.0;   ///< [s]
  double dt_ = 0.0;
};

double Drive::frictionAt(double w, double load, double angle, double temperature, double humidity, double vibration,
                         double t) {
  // The bristle follows the motion and slips at full deflection (implicit Euler).
  bristle_ = (bristle_ + w * dt_ / secret_.bristle_travel) / (1.0 + std::fabs(w) * dt_ / secret_.bristle_travel);
  rested_ = std::fabs(w) < 0.05 ? rested_ + dt_ : rested_;
  const double slow = std::exp(-std::pow(std::fabs(w) / rig_.stribeck_speed, rig_.stribeck_power));
  const double size = std::fabs(load);
  double level = rig_.sliding * size + (rig_.breakaway - rig_.sliding) * size * slow;
  level += secret_.coulomb_offset + (secret_.static_offset + secret_.ageing * std::log1p(rested_)) * slow;
  level += secret_.load_quadratic * size * size;
  level *= std::exp(secret_.capstan * angle - secret_.dry_heating * (temperature - 28.0));
  level *= 1.0 + secret_.direction_share * (w > 0.0 ? 1.0 : w < 0.0 ? -1.0 : (bristle_ > 0.0 ? 1.0 : -1.0));
  if (t >= secret_.change_time) level *= 1.0 + secret_.change_share;
  double viscous = rig_.viscous * w * std::exp(-secret_.viscous_heating * (temperature - 28.0));
  if (secret_.viscous_bend != 0.0 && w != 0.0) viscous *= std::pow(std::fabs(w) / 100.0, secret_.viscous_bend);
  double friction = level * bristle_ + viscous;
  friction *= 1.0 + secret_.backdrive_share * (load * bristle_ > 0.0 ? 1.0 : -1.0);
  const double humid = (humidity - 45.0) / 10.0;
  friction *= 1.0 + secret_.humid_friction * humid + (humidity > 45.0 ? secret_.humid_threshold : 0.0) +
              secret_.humid_angle * humid * angle - secret_.vibration * vibration;
  return friction;
}

Truth Drive::run() {
  constexpr int kDriveSubsteps = 8;
  std::mt19937_64 random(rig_.seed);
  std::uniform_real_distribution<double> u;
  Truth truth;
  DriveRecord& r = truth.record;
  const double sample = 1.0 / rig_.rate;
  dt_ = sample / kDriveSubsteps;
  double temperature = 20.0;
  const double day = 300.0 + 300.0 * u(random), phase = kTwoPi * u(random), humid_phase = kTwoPi * u(random);
  for (int session = 0; r.time.size() < rig_.rows; ++session) {
    const Run run = drawRun(random, rig_);
    const auto length = static_cast<std::size_t>((16.0 + 28.0 * u(random)) * rig_.rate);
    rested_ = 0.0;
    double shown = 0.0;                                        // load, behind the torque sensor's filter
    const double shaking = u(random) < 0.5 ? 0.0 : u(random);  // of this session
    for (std::size_t k = 0; k < length && r.time.size() < rig_.rows; ++k) {
      const double clock = static_cast<double>(r.time.size()) * sample;
      const double humidity = 45.0 + 15.0 * std::sin(kTwoPi * clock / (0.77 * day) + humid_phase);
      const double vibration = shaking * (0.6 + 0.4 * std::sin(kTwoPi * clock / 37.0));
      const double room = 24.0 + 8.0 * std::sin(kTwoPi * clock / day + phase);
      double torque = 0.0, load = 0.0, w = 0.0, angle = 0.0;
      for (int s = 0; s < kDriveSubsteps; ++s) {
        const double t = static_cast<double>(k) * sample + (s - kDriveSubsteps + 1) * dt_;
        const double h = 1e-4;
        angle = run.angle(std::max(t, 0.0));
        const double ahead = run.angle(std::max(t, 0.0) + h), behind = run.angle(std::max(t, 0.0) - h);
        w = (ahead - behind) / (2.0 * h) * rig_.ratio;
        if (std::fabs(w) < 1e-7) w = 0.0;
        const double a = (ahead - 2.0 * angle + behind) / (h * h) * rig_.ratio;
        load = run.weight * std::sin(angle - run.weight_angle) + 0.04 * run.weight * a / rig_.ratio;
        const double inner = load + secret_.hidden_weight * std::sin(angle - secret_.hidden_angle);
        if (std::fabs(w) > 20.0) rested_ = 0.0;  // under way: the contact is new again
        const double friction = frictionAt(w, inner, angle, temperature, humidity, vibration, clock);
        if (secret_.sensor_filter > 0.0 && (k > 0 || s > 0)) {
          shown += (1.0 - std::exp(-dt_ / secret_.sensor_filter)) * (load - shown);
        } else {
          shown = load;
        }
        torque = inner + friction + secret_.inertia * a + secret_.ripple * std::sin(secret_.ripple_ratio * angle + 1.0);
        const double heat = std::fabs(friction * w);  // [W] at the motor's side of the cable, as far as it counts here
        temperature += dt_ * ((room - temperature) / 40.0 + heat / 900.0);
      }
      double current = torque / (rig_.torque_per_ampere * (1.0 - secret_.magnet_heating * (temperature - 28.0)));
      current += secret_.saturation * current * current * current + secret_.current_bias;
      current += secret_.humid_current * (humidity - 45.0) / 10.0;
      r.time.push_back(clock);
      r.current.push_back(current);
      r.velocity.push_back(w);
      r.torque.push_back(shown / (1.0 + secret_.gauge_bend * shown) - secret_.torque_bias);
      r.angle.push_back(angle);
      r.temperature.push_back(temperature);
      r.humidity.push_back(humidity);
      r.vibration.push_back(vibration);
      r.session.push_back(session);
    }
  }
  if (secret_.delay != 0.0) {  // what is logged now was drawn `delay` ago
    const std::vector<double> now = r.current;
    for (std::size_t i = 0; i < now.size(); ++i) {
      const double at = static_cast<double>(i) - secret_.delay / sample;
      const double low = std::floor(at);
      const auto pick = [&](double index) {
        const auto j = static_cast<std::size_t>(std::clamp(index, 0.0, static_cast<double>(now.size() - 1)));
        return r.session[j] == r.session[i] ? now[j] : now[i];
      };
      r.current[i] = pick(low) + (at - low) * (pick(low + 1.0) - pick(low));
    }
  }
  return truth;
}

double roundedTo(double value, double digits) { return std::round(value * digits) / digits; }

}  // namespace

DriveRecord recordDrive(const DriveRig& rig, const DriveSecret& secret) {
  DriveRecord record = Drive(rig, secret).run().record;
  std::mt19937_64 random(rig.seed ^ 0x9e3779b97f4a7c15ULL);
  std::normal_distribution<double> normal;
  double noise = 0.0;
  for (std::size_t i = 0; i < record.time.size(); ++i) {
    noise = rig.current_memory * noise +
            rig.current_noise * std::sqrt(1.0 - rig.current_memory * rig.current_memory) * normal(random);
    record.current[i] = roundedTo(record.current[i] + noise, 100.0);
    record.velocity[i] = roundedTo(record.velocity[i] + rig.velocity_noise * normal(random), 1e4);
    record.torque[i] = roundedTo(record.torque[i] + rig.torque_noise * normal(random), 1e4);
    record.angle[i] = roundedTo(record.angle[i] + rig.angle_noise * normal(random), 1e5);
    record.temperature[i] = roundedTo(record.temperature[i] + 0.1 * normal(random), 100.0);
    record.humidity[i] = roundedTo(record.humidity[i] + 0.3 * normal(random), 10.0);
    record.vibration[i] = roundedTo(std::max(record.vibration[i] + 0.01 * normal(random), 0.0), 1000.0);
  }
  return record;
}

std::string csvWithMotorAngle(const DriveRecord& record, double ratio, double stretch, double play) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> noise(0.0, 2e-3);
  CsvWriter csv({"time_s", "motor_current_A", "motor_velocity_rad_s", "external_torque_Nm", "joint_position_rad",
                 "motor_position_rad", "session"});
  double in_play = 0.0;  // [rad] from the middle of the play
  for (std::size_t i = 0; i < record.time.size(); ++i) {
    const double load = record.torque[i];
    const double stretched = std::copysign(stretch * (1.0 - std::exp(-std::abs(load) / 6.0)), load);
    in_play += 0.4 * (std::copysign(0.5 * play, load) - in_play);
    const double motor =
        ratio * (record.angle[i] + stretched + in_play + noise(random)) + 0.003 * record.velocity[i] + 12.0;
    csv.add(record.time[i]).add(record.current[i]).add(record.velocity[i]).add(load).add(record.angle[i]).add(motor);
    csv.add(static_cast<double>(record.session[i])).endRow();
  }
  return csv.text();
}

double expectedGain(const DriveRig& rig, const DriveSecret& secret) {
  DriveSecret plain;
  plain.bristle_travel = std::min(secret.bristle_travel, DriveSecret().bristle_travel);
  const DriveRecord with = Drive(rig, secret).run().record, without = Drive(rig, plain).run().record;
  const auto n = static_cast<Eigen::Index>(with.time.size());
  Eigen::MatrixXd x(n, 6);
  Eigen::VectorXd y(n);
  double direction = 1.0;
  for (Eigen::Index i = 0; i < n; ++i) {
    const auto k = static_cast<std::size_t>(i);
    const double w = with.velocity[k], load = with.torque[k];
    if (std::fabs(w) > 1e-6) direction = w > 0.0 ? 1.0 : -1.0;
    const double slow = std::pow(std::fabs(w) / rig.stribeck_speed, rig.stribeck_power);
    const double e = std::exp(-slow), dry = std::fabs(load) * direction;
    x.row(i) << load, dry, dry * e, w, dry * e * slow, slow > 0.0 ? dry * e * slow * std::log(slow) : 0.0;
    y[i] = with.current[k] - without.current[k];
  }
  const Eigen::VectorXd rest = y - x * x.colPivHouseholderQr().solve(y);
  const double added = rest.squaredNorm() / static_cast<double>(n);
  return added / (added + rig.current_noise * rig.current_noise);
}

std::string DriveRecord::csv() const {
  CsvWriter writer({"time_s", "motor_current_A", "motor_velocity_rad_s", "external_torque_Nm", "joint_position_rad",
                    "temperature_degC", "humidity_percent", "vibration_g", "session"});
  for (std::size_t i = 0; i < time.size(); ++i) {
    writer.add(time[i]).add(current[i]).add(velocity[i]).add(torque[i]).add(angle[i]).add(temperature[i]);
    writer.add(humidity[i]).add(vibration[i]).add(static_cast<double>(session[i])).endRow();
  }
  return writer.text();
}

}  // namespace simgap::reality
