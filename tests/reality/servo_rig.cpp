#include "reality/servo_rig.h"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace simgap::reality {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kServoStep = 2.5e-4;  // [s] of the integration
constexpr int kControlEvery = 4;       // steps
constexpr double kReference = 28.0;    // [degC]
constexpr double kOffSeconds = 1.5;    // switched off

/// Where the drive should be: moves with rests, swings and slow sweeps, one after the other.
class Plan {
 public:
  Plan(const ServoRig& rig, double seconds, std::mt19937_64& random) {
    std::uniform_real_distribution<double> u;
    const double top = rig.top_speed / rig.ratio;
    const bool turns = rig.mechanism == Mechanism::kGearedJoint;
    const double middle = turns ? 0.0 : -0.6 + 1.2 * u(random), reach = (turns ? 0.8 : 0.3) + 0.7 * u(random);
    at_ = middle + reach * (2.0 * u(random) - 1.0);
    hold(0.6 + u(random));
    while (end_ < seconds) {
      const double kind = u(random);
      if (kind < 0.5) {
        const double speed = top * (0.05 + 0.6 * u(random)), to = middle + reach * (2.0 * u(random) - 1.0);
        move(to, speed);
        hold(0.3 * std::pow(50.0, u(random)));
      } else if (kind < 0.8) {
        const double amplitude = reach * (0.3 + 0.7 * u(random));
        move(middle, 0.4 * top);
        const int periods = 2 + int(4.0 * u(random));
        swing(amplitude, std::min(top * (0.2 + 0.7 * u(random)) / (kTurn * amplitude), 1.5), periods);
      } else {  // slow, there and back
        const double there = middle + reach * (2.0 * u(random) - 1.0), back = at_,
                     speed = top * (0.03 + 0.12 * u(random));
        move(there, speed);
        move(back, speed);
      }
    }
  }

  double angle(double t) const {
    std::size_t k = 0;
    while (k + 1 < pieces_.size() && t >= pieces_[k + 1].start) ++k;
    const Piece& p = pieces_[k];
    const double s = std::clamp((t - p.start) / p.seconds, 0.0, 1.0);
    if (p.periods > 0) {
      const double ramp = std::min(1.0, std::min(s, 1.0 - s) * 2.0 * p.periods);
      return p.from + p.reach * ramp * ramp * (3.0 - 2.0 * ramp) * std::sin(kTurn * p.periods * s);
    }
    return p.from + p.reach * s * s * s * (10.0 - 15.0 * s + 6.0 * s * s);
  }

 private:
  struct Piece {
    double start, seconds, from, reach;
    int periods;
  };

  void add(double seconds, double reach, int periods) {
    pieces_.push_back({end_, seconds, at_, reach, periods});
    end_ += seconds;
  }
  void hold(double seconds) { add(seconds, 0.0, 0); }
  void move(double to, double speed) {
    add(std::max(0.3, 1.9 * std::fabs(to - at_) / speed), to - at_, 0);
    at_ = to;
  }
  void swing(double amplitude, double frequency, int periods) { add(periods / frequency, amplitude, periods); }

  std::vector<Piece> pieces_;
  double at_ = 0.0, end_ = 0.0;
};

/// What is around the drive and no motion of its own.
struct Surroundings {
  double day, phase, humid_phase, supply_phase, neighbour_phase;

  explicit Surroundings(std::mt19937_64& random) {
    std::uniform_real_distribution<double> u;
    day = 250.0 + 250.0 * u(random);
    phase = kTurn * u(random), humid_phase = kTurn * u(random);
    supply_phase = kTurn * u(random), neighbour_phase = kTurn * u(random);
  }
  double room(double t) const { return 25.0 + 8.0 * std::sin(kTurn * t / day + phase); }
  double humidity(double t) const { return 45.0 + 15.0 * std::sin(kTurn * t / (0.71 * day) + humid_phase); }
  double supply(double t) const {
    return 12.0 + 0.6 * std::sin(kTurn * t / 41.0 + supply_phase) + 0.3 * std::sin(kTurn * t / 13.7);
  }
  double neighbour(double t) const {
    return std::sin(kTurn * t / 3.1 + neighbour_phase) + 0.7 * std::sin(kTurn * t / 1.9 + 2.0);
  }
};

/// A cascade of a position and a velocity loop, sampled, saturated, with an encoder of its own.
class Controller {
 public:
  explicit Controller(const ServoRig& rig) : rig_(rig) {
    gain_ = std::max(rig.largest_effort / rig.top_speed, 40.0 * rig.inertia / rig.strength);
    integral_gain_ = rig.mechanism == Mechanism::kVoltageServo ? 0.0 : 8.0 * gain_;
    count_ = kTurn / (rig.counts * 16.0);
  }
  void start(double q) { last_ = q, speed_ = 0.0, integral_ = 0.0; }
  double effort(double wanted, double wanted_speed, double q, double dt) {
    const double read = std::floor(q / count_) * count_;
    speed_ += 0.3 * ((read - last_) / dt - speed_);
    last_ = read;
    const double error = wanted_speed + 8.0 * (wanted - read) - speed_;
    const double u = gain_ * error + integral_;
    const double limited = std::clamp(u, -rig_.largest_effort, rig_.largest_effort);
    if (u == limited) integral_ += integral_gain_ * error * dt;
    return limited;
  }

 private:
  const ServoRig& rig_;
  double gain_, integral_gain_, count_;
  double last_ = 0.0, speed_ = 0.0, integral_ = 0.0;
};

class ServoDrive {
 public:
  ServoDrive(const ServoRig& rig, const ServoSecret& secret) : rig_(rig), secret_(secret) {
    dry_size_ = rig.mechanism == Mechanism::kCable ? 0.5 * rig.dry_per_load * rig.weight : rig.dry;
    travel_ = secret.bristle_travel > 0.0 ? secret.bristle_travel : plainTravel();
  }
  void start(double q, double weight, double weight_angle) {
    q_ = q, w_ = 0.0, bristle_ = plain_bristle_ = 0.0, rested_ = 0.0, weight_ = weight, weight_angle_ = weight_angle;
    gap_ = 0.5 * secret_.backlash;
  }
  /// Its terminals are open from now on, or no more: no current, whatever its speed.
  void switchOff(bool off) { off_ = off; }
  /// One step under the controller's effort. \param change  how far a change of regime has come, 0 to 1.
  void step(double effort, double change, double humidity, double supply, double neighbour, double room);

  double q() const { return q_; }
  double joint() const { return q_ / rig_.ratio; }
  double w() const { return w_; }
  double load() const { return load_; }
  double temperature() const { return temperature_; }
  double extra() const { return extra_; }
  bool moving() const { return std::fabs(w_) > 1e-3 * rig_.top_speed; }

 private:
  double plainTravel() const { return 2e-4 * rig_.top_speed; }
  double plainLevel(double w) const;
  double secretLevel(double w, double load, double change, double humidity) const;
  double harnessTorque() const;
  double secretViscous(double w) const;
  double motorTorque(double effort, double supply) const;
  void sagRail(double effort);
  double dryDirection(double free, double level, double viscous, double inertia);

  const ServoRig& rig_;
  const ServoSecret& secret_;
  bool off_ = false;
  double dry_size_, travel_;
  double q_ = 0.0, w_ = 0.0, bristle_ = 0.0, plain_bristle_ = 0.0, rested_ = 0.0, gap_ = 0.0;
  double rail_ = 1.0;  // of its voltage without load
  double weight_ = 0.0, weight_angle_ = 0.0, temperature_ = 22.0, load_ = 0.0, extra_ = 0.0;
};

double ServoDrive::plainLevel(double w) const {
  const double sliding = rig_.dry + rig_.dry_per_load * std::fabs(load_);
  return sliding * (1.0 + (rig_.breakaway - 1.0) * lorentzian(w, rig_.stribeck_speed));
}

double ServoDrive::secretLevel(double w, double load, double change, double humidity) const {
  const ServoSecret& s = secret_;
  const double slow = lorentzian(w, rig_.stribeck_speed), size = std::fabs(load);
  const double sliding = rig_.dry + rig_.dry_per_load * size;
  double level = sliding * (1.0 + (rig_.breakaway - 1.0 + s.stribeck_share) * slow);
  level += s.dry_offset + s.static_offset * slow + s.load_power * std::pow(size, 1.6) + s.load_share * size;
  if (s.ageing != 0.0) level += s.ageing * std::pow(rested_, 0.35) * slow;
  const double bent = s.bend_both_ways   ? std::hypot(joint(), 0.15)
                      : s.bend_saturates ? std::tanh(1.5 * joint()) / 1.5
                                         : joint();
  level *= std::max(0.1, 1.0 + s.bend * bent) * (1.0 + s.change_share * change);
  const double way = w != 0.0 ? w : bristle_;
  level *= 1.0 + std::copysign(s.direction_share, way) + std::copysign(s.backdrive_share, load * way);
  return level * (1.0 + s.humid_friction * (humidity - 45.0) / 10.0);
}

double ServoDrive::secretViscous(double w) const {
  const double size = 1.0 + std::copysign(secret_.viscous_asymmetry, w);
  return rig_.viscous * w * size / (1.0 + secret_.viscous_saturation * std::fabs(w) / rig_.top_speed);
}

double ServoDrive::motorTorque(double effort, double supply) const {
  const ServoSecret& s = secret_;
  const double most = rig_.largest_effort * std::max(0.05, 1.0 - s.headroom * std::fabs(w_) / rig_.top_speed);
  double used = s.headroom > 0.0 ? std::clamp(effort, -most, most) : effort;
  if (s.knee_loss > 0.0 && std::fabs(used) > s.knee) {
    used = std::copysign(s.knee + (std::fabs(used) - s.knee) / (1.0 + s.knee_loss), used);
  }
  used *= (1.0 + s.supply_effort * (supply - 12.0)) * rail_;
  return rig_.strength * (used / (1.0 + s.magnet_heating * (temperature_ - kReference)) - rig_.back_emf * w_);
}

/// A bridge draws the winding's current during its duty from a rail behind a resistance, buffered by a capacitor.
void ServoDrive::sagRail(double effort) {
  constexpr double kBuffered = 5e-3;  // [s]
  const double over_winding = std::fabs(effort * rail_ - rig_.back_emf * w_);
  const double duty = std::min(1.0, std::fabs(effort) / rig_.largest_effort);
  rail_ += kServoStep / kBuffered * (std::max(0.2, 1.0 - secret_.rail_sag * duty * over_winding) - rail_);
}

/// The share of the dry friction that acts, -1 to 1, and the motion's step under it. \param free  torque without it.
double ServoDrive::dryDirection(double free, double level, double viscous, double inertia) {
  const double damping = 1.0 + kServoStep * viscous / inertia;
  const double before = w_;
  double share = 0.0;
  if (rig_.bristle || secret_.bristle_travel > 0.0) {
    bristle_ = (bristle_ + w_ * kServoStep / travel_) / (1.0 + std::fabs(w_) * kServoStep / travel_) *
               (1.0 - kServoStep / 15.0);
    const double micro = 0.6 * std::sqrt(inertia * level / travel_) * std::exp(-std::fabs(w_) / rig_.stribeck_speed);
    w_ = (before + kServoStep / inertia * (free - level * bristle_)) / (damping + kServoStep * micro / inertia);
    share = bristle_ + micro * w_ / std::max(level, 1e-9);
  } else {
    const double most = kServoStep * level / inertia, driven = before + kServoStep * free / inertia;
    if (std::fabs(driven) <= most) {  // held: anything within the band, and a little creep
      share = driven / std::max(most, 1e-12);
      w_ = std::copysign(1e-5 * rig_.top_speed * std::exp(12.0 * (std::fabs(share) - 1.0)), share);
    } else {
      share = driven > 0.0 ? 1.0 : -1.0;
      w_ = (driven - share * most) / damping;
    }
  }
  plain_bristle_ =
      (plain_bristle_ + w_ * kServoStep / plainTravel()) / (1.0 + std::fabs(w_) * kServoStep / plainTravel());
  return share;
}

double ServoDrive::harnessTorque() const {
  const double stretch = joint() - secret_.harness_angle;
  if (secret_.harness_slack) return 0.5 * secret_.harness * (stretch + std::hypot(stretch, 0.1));
  return secret_.harness * std::sinh(0.8 * stretch) / 0.8;
}

void ServoDrive::step(double effort, double change, double humidity, double supply, double neighbour, double room) {
  const ServoSecret& s = secret_;
  load_ = weight_ * std::sin(joint() - weight_angle_);
  double engaged = 1.0;
  if (s.backlash > 0.0) {
    gap_ = std::clamp(gap_ + w_ * kServoStep, 0.0, s.backlash);
    engaged = gap_ > 0.0 && gap_ < s.backlash ? 0.0 : 1.0;
  }
  const double warm = 1.0 / (1.0 + s.friction_heating * (temperature_ - kReference));
  const double inner = load_ + s.hidden_weight * std::sin(joint() - s.hidden_angle) + harnessTorque();
  const double phase = s.ripple_ratio * joint() + 1.0;
  const double ripple = s.ripple * (std::sin(phase) + 0.5 * std::sin(2.0 * phase + 0.7) + 0.25 * std::sin(3.0 * phase));
  const double level = engaged * warm * secretLevel(w_, inner, change, humidity);
  const double viscous = warm * secretViscous(w_);
  const double slope = w_ != 0.0 ? viscous / w_ : warm * rig_.viscous;
  const double torque = off_ ? 0.0 : motorTorque(effort, supply);
  sagRail(off_ ? 0.0 : effort);
  const double inertia = rig_.inertia + s.inertia, before = w_, plain_viscous = rig_.viscous * w_;
  const double plain_level = plainLevel(w_);
  const double free = torque - engaged * inner - ripple - s.neighbour * neighbour;
  const double share = dryDirection(free, level, slope, inertia);
  const double plain_share = s.bristle_travel > 0.0 ? plain_bristle_ : share;
  const double acceleration = (w_ - before) / kServoStep;
  const double secret = engaged * inner + level * share + viscous + ripple + s.neighbour * neighbour +
                        s.inertia * acceleration - load_ - plain_level * plain_share - plain_viscous;
  extra_ = effort - (torque - secret) / rig_.strength - rig_.back_emf * before + s.bias;
  q_ += kServoStep * w_;
  rested_ = std::fabs(w_) < 2e-3 * rig_.top_speed  ? rested_ + kServoStep
            : std::fabs(w_) > 0.1 * rig_.top_speed ? 0.0
                                                   : rested_;
  const double heat = std::fabs(level * share * w_) / (dry_size_ * rig_.top_speed);
  temperature_ += kServoStep * ((room - temperature_) / 60.0 + 0.5 * heat);
}

/// Reads the effort `delay` late, within sessions.
void delayEffort(ServoRecord& r, double rows_late) {
  const std::vector<double> now = r.effort;
  for (std::size_t i = 0; i < now.size(); ++i) {
    const double at = static_cast<double>(i) - rows_late, low = std::floor(at);
    const auto pick = [&](double index) {
      const auto j = static_cast<std::size_t>(std::clamp(index, 0.0, static_cast<double>(now.size() - 1)));
      return r.session[j] == r.session[i] ? now[j] : now[i];
    };
    r.effort[i] = pick(low) + (at - low) * (pick(low + 1.0) - pick(low));
    r.extra[i] += r.effort[i] - now[i];
  }
}

void logRow(ServoRecord& r, double time, int session, double effort, const ServoDrive& plant) {
  r.time.push_back(time);
  r.session.push_back(session);
  r.effort.push_back(effort);
  r.position.push_back(plant.q());
  r.speed.push_back(plant.w());
  r.load.push_back(plant.load());
  r.joint.push_back(plant.joint());
  r.temperature.push_back(plant.temperature());
  r.extra.push_back(plant.extra());
  r.moving.push_back(plant.moving());
}

}  // namespace

ServoRecord driveServo(const ServoRig& rig, const ServoSecret& secret) {
  std::mt19937_64 random(rig.seed * 2654435761ULL + 3);
  std::uniform_real_distribution<double> u;
  std::normal_distribution<double> normal;
  const Surroundings around(random);
  ServoDrive plant(rig, secret);
  Controller controller(rig);
  ServoRecord r;
  r.mechanism = rig.mechanism;
  const int per_row = static_cast<int>(std::lround(1.0 / (rig.rate * kServoStep)));
  for (int session = 0; r.time.size() < rig.rows; ++session) {
    const double seconds = 25.0 + 35.0 * u(random);
    const Plan plan(rig, seconds, random);
    const bool hangs = rig.mechanism == Mechanism::kCable;
    const double weight =
        !hangs ? rig.weight : rig.weight * (u(random) < 0.2 ? 0.03 * u(random) : 0.15 + 0.85 * u(random));
    plant.start(rig.ratio * plan.angle(0.0), weight, hangs ? -0.8 + 1.6 * u(random) : 0.0);
    controller.start(plant.q());
    double effort = 0.0;
    const auto rows = static_cast<std::size_t>(seconds * rig.rate);
    for (std::size_t k = 0; k < rows && r.time.size() < rig.rows; ++k) {
      const double clock = static_cast<double>(r.time.size()) / rig.rate;
      const double late = 0.5 + std::clamp(rig.jitter * normal(random), -0.4, 0.4);  // of a step
      const int sampled = static_cast<int>((rig.stamps_lie ? 0.5 : late) * per_row);
      const double change = std::clamp((clock - secret.change_time) / 3.0, 0.0, 1.0);
      const double humidity = around.humidity(clock), supply = around.supply(clock);
      for (int j = 0; j < per_row; ++j) {
        const double t = static_cast<double>(k) / rig.rate + j * kServoStep;
        if (j % kControlEvery == 0) {
          const double dt = kServoStep * kControlEvery, now = plan.angle(t), soon = plan.angle(t + dt);
          effort = controller.effort(rig.ratio * now, rig.ratio * (soon - now) / dt, plant.q(), dt);
        }
        const bool off = rig.off_every > 0.0 && std::fmod(t, rig.off_every) > rig.off_every - kOffSeconds;
        if (off) effort = 0.0;
        plant.switchOff(off);
        plant.step(effort, change, humidity, supply, around.neighbour(clock), around.room(clock));
        if (j == sampled) logRow(r, clock + late / rig.rate, session, effort + secret.bias, plant);
      }
      r.humidity.push_back(humidity);
      r.supply.push_back(supply);
      r.neighbour.push_back(around.neighbour(clock));
    }
  }
  if (secret.delay != 0.0) delayEffort(r, secret.delay * rig.rate);
  return r;
}

}  // namespace simgap::reality
