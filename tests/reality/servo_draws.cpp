#include "reality/servo_draws.h"

#include <algorithm>
#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <stdexcept>

namespace simgap::reality {
namespace {

using enum Mechanism;
using ServoSetter = std::function<void(ServoSecret&, double)>;

/// Sizes are relative to the rig: dry friction, top speed, largest effort.
struct Scale {
  double dry, torque, speed, effort, travel;
};

struct ServoDrawable {
  std::string name;
  std::vector<Mechanism> on;
  std::function<std::pair<double, double>(const Scale&)> range;  ///< first guess and largest magnitude
  ServoSetter set;
};

std::function<std::pair<double, double>(const Scale&)> share(double guess, double most) {
  return [=](const Scale&) { return std::pair(guess, most); };
}

const std::vector<Mechanism> kAll = {kCable, kGearedJoint, kPendulum, kVoltageServo};

std::vector<ServoDrawable> frictionDrawables() {
  return {
      {"coulomb-offset",
       {kCable},
       [](const Scale& s) { return std::pair(0.2 * s.dry, 2.0 * s.dry); },
       [](ServoSecret& s, double m) { s.dry_offset = m; }},
      {"static-offset",
       {kCable},
       [](const Scale& s) { return std::pair(0.3 * s.dry, 2.0 * s.dry); },
       [](ServoSecret& s, double m) { s.static_offset = m; }},
      {"load-nonlinearity", {kCable}, share(0.02, 0.3), [](ServoSecret& s, double m) { s.load_power = m; }},
      {"load-dependence",
       {kPendulum, kVoltageServo},
       share(0.1, 0.6),
       [](ServoSecret& s, double m) { s.load_share = m; }},
      {"direction-asymmetry", {kCable}, share(0.1, 0.6), [](ServoSecret& s, double m) { s.direction_share = m; }},
      {"backdrive-asymmetry",
       {kPendulum, kVoltageServo},
       share(0.2, 0.6),
       [](ServoSecret& s, double m) { s.backdrive_share = m; }},
      {"viscous-asymmetry", kAll, share(0.2, 0.8), [](ServoSecret& s, double m) { s.viscous_asymmetry = m; }},
      {"viscous-nonlinearity", kAll, share(1.0, 8.0), [](ServoSecret& s, double m) { s.viscous_saturation = m; }},
      {"stribeck", {kGearedJoint, kPendulum}, share(0.5, 3.0), [](ServoSecret& s, double m) { s.stribeck_share = m; }},
      {"bend-friction", {kCable}, share(0.2, 0.9), [](ServoSecret& s, double m) { s.bend = m; }},
      {"presliding-hysteresis", kAll, [](const Scale& s) { return std::pair(30.0 * s.travel, 600.0 * s.travel); },
       [](ServoSecret& s, double m) { s.bristle_travel = m; }},
      {"stiction-ageing",
       {kCable, kGearedJoint},
       [](const Scale& s) { return std::pair(0.3 * s.dry, 2.0 * s.dry); },
       [](ServoSecret& s, double m) { s.ageing = m; }},
      {"friction-heating", kAll, share(0.02, 0.12), [](ServoSecret& s, double m) { s.friction_heating = m; }}};
}

std::vector<ServoDrawable> otherDrawables() {
  return {
      {"inertia",
       {kCable},
       [](const Scale& s) { return std::pair(0.1 * s.torque / s.speed, s.torque / s.speed); },
       [](ServoSecret& s, double m) { s.inertia = m; }},
      {"joint-gravity",
       {kCable, kGearedJoint},
       [](const Scale& s) { return std::pair(0.1 * s.torque, s.torque); },
       [](ServoSecret& s, double m) { s.hidden_weight = m; }},
      {"position-ripple", kAll, [](const Scale& s) { return std::pair(0.1 * s.dry, s.dry); },
       [](ServoSecret& s, double m) { s.ripple = m; }},
      {"torque-constant-heating",
       {kCable, kPendulum},
       share(0.005, 0.05),
       [](ServoSecret& s, double m) { s.magnet_heating = m; }},
      {"torque-saturation", {kCable, kPendulum}, share(0.2, 1.5), [](ServoSecret& s, double m) { s.knee_loss = m; }},
      {"current-bias",
       {kCable, kPendulum},
       [](const Scale& s) { return std::pair(0.02 * s.effort, 0.3 * s.effort); },
       [](ServoSecret& s, double m) { s.bias = m; }},
      {"channel-delay", kAll, share(0.03, 0.15), [](ServoSecret& s, double m) { s.delay = m; }},
      {"regime-change", kAll, share(0.15, 1.0), [](ServoSecret& s, double m) { s.change_share = m; }},
      {"speed-limit", {kGearedJoint, kVoltageServo}, share(0.5, 1.5), [](ServoSecret& s, double m) { s.headroom = m; }},
      {"backlash",
       {kGearedJoint},
       [](const Scale& s) { return std::pair(50.0 * s.travel, 600.0 * s.travel); },
       [](ServoSecret& s, double m) { s.backlash = m; }},
      {"joint-spring",
       {kCable, kGearedJoint, kPendulum},
       [](const Scale& s) { return std::pair(0.05 * s.torque, s.torque); },
       [](ServoSecret& s, double m) { s.harness = m; }}};
}

const std::vector<ServoDrawable>& servoDrawables() {
  static const std::vector<ServoDrawable> list = [] {
    std::vector<ServoDrawable> all = frictionDrawables();
    std::ranges::copy(otherDrawables(), std::back_inserter(all));
    return all;
  }();
  return list;
}

const std::vector<ServoDrawable>& servoOutside() {
  static const std::vector<ServoDrawable> list = {
      {"humidity-friction", kAll, share(0.1, 0.5), [](ServoSecret& s, double m) { s.humid_friction = m; }},
      {"supply-effort", {kCable, kPendulum}, share(0.05, 0.5), [](ServoSecret& s, double m) { s.supply_effort = m; }},
      {"neighbour-torque", kAll, [](const Scale& s) { return std::pair(0.05 * s.torque, 0.5 * s.torque); },
       [](ServoSecret& s, double m) { s.neighbour = m; }}};
  return list;
}

std::vector<std::string> servoNames(const std::vector<ServoDrawable>& list) {
  std::vector<std::string> names;
  for (const ServoDrawable& d : list) names.push_back(d.name);
  return names;
}

const ServoDrawable& findServoDrawable(const std::vector<ServoDrawable>& list, const std::string& name) {
  for (const ServoDrawable& d : list) {
    if (d.name == name) return d;
  }
  throw std::runtime_error("no such secret: " + name);
}

void drawMechanism(ServoRig& rig, std::mt19937_64& random) {
  std::uniform_real_distribution<double> u;
  const auto near = [&](double value) { return value * std::pow(2.0, 1.2 * u(random) - 0.6); };
  switch (rig.mechanism) {
    case kCable:
      rig.strength = near(1.2), rig.dry_per_load = near(0.26), rig.viscous = near(0.015), rig.inertia = 3e-4;
      rig.weight = near(13.0), rig.ratio = 97.74, rig.top_speed = near(90.0), rig.stribeck_speed = near(4.0);
      rig.largest_effort = 2.2 * rig.weight / rig.strength, rig.effort_noise = near(0.2), rig.counts = 2000.0;
      break;
    case kGearedJoint:
      rig.strength = 1.0, rig.dry = near(1.0), rig.viscous = near(0.8), rig.inertia = near(0.4);
      rig.top_speed = near(1.6), rig.stribeck_speed = near(0.05), rig.largest_effort = 5.0;
      rig.effort_noise = near(0.08), rig.counts = 1e5, rig.effort_step = 0.01;
      break;
    case kPendulum:
      rig.strength = near(0.9), rig.dry = near(0.12), rig.viscous = near(0.02), rig.weight = near(1.1);
      rig.inertia = rig.weight * 0.15 / 9.81 * 1.2, rig.top_speed = near(3.5), rig.stribeck_speed = near(0.12);
      rig.largest_effort = 3.5 * rig.weight / rig.strength, rig.effort_noise = near(0.03), rig.counts = 4096.0;
      rig.effort_step = 0.005;
      break;
    case kVoltageServo:
      rig.strength = near(0.25), rig.dry = near(0.3), rig.viscous = near(0.05), rig.weight = near(0.9);
      rig.inertia = rig.weight * 0.15 / 9.81 * 1.4, rig.top_speed = near(4.5), rig.stribeck_speed = near(0.15);
      rig.back_emf = 1.0, rig.largest_effort = 12.0, rig.effort_noise = near(0.15), rig.counts = 4096.0;
      rig.effort_step = 0.05;
      break;
  }
}

ServoRig drawServoRig(std::uint64_t seed, Mechanism mechanism) {
  std::mt19937_64 random(seed * 6271 + 29);
  std::uniform_real_distribution<double> u;
  ServoRig rig;
  rig.mechanism = mechanism;
  rig.seed = seed;
  drawMechanism(rig, random);
  rig.bristle = u(random) < 0.5;
  rig.breakaway = 1.1 + 0.6 * u(random);
  rig.effort_memory = 0.7 * u(random);
  rig.spike_share = 2e-4 * std::pow(5.0, u(random));
  rig.jitter = 0.1 * u(random);
  rig.stamps_lie = u(random) < 0.5;
  rig.gap = 5.0 + 25.0 * u(random);
  rig.clipped_share = u(random) < 0.3 ? 0.005 + 0.02 * u(random) : 0.0;
  rig.rows = static_cast<std::size_t>(12000 + 12000 * u(random));
  return rig;
}

/// Details that the magnitude does not set: when, where, which ratio.
void drawServoDetails(ServoSecret& secret, const ServoRig& rig, std::mt19937_64& random) {
  std::uniform_real_distribution<double> u;
  secret.hidden_angle = -1.2 + 2.4 * u(random);
  secret.ripple_ratio = 8.0 + 50.0 * u(random);
  secret.change_time = static_cast<double>(rig.rows) / rig.rate * (0.25 + 0.5 * u(random));
  secret.bend_saturates = u(random) < 0.5;
  secret.knee = rig.largest_effort * (0.12 + 0.15 * u(random));
  std::mt19937_64 of_harness(rig.seed * 131 + 17);  // its own: the others stay as they were before there was one
  secret.harness_slack = u(of_harness) < 0.5;
  secret.harness_angle = -0.3 + 0.6 * u(of_harness);
}

Scale scaleOf(const ServoRig& rig) {
  const double dry = rig.mechanism == kCable ? 0.5 * rig.dry_per_load * rig.weight : rig.dry;
  return {dry, std::max(0.3 * rig.weight, dry), rig.top_speed, rig.largest_effort, 2e-4 * rig.top_speed};
}

/// The magnitude at which a model of the secret would gain `gain`, or the largest.
double servoMagnitude(const ServoDrawable& drawable, double gain, const ServoRig& rig, ServoSecret& secret) {
  ServoRig quick = rig;
  quick.rows = std::min<std::size_t>(rig.rows, 8000);
  auto [magnitude, high] = drawable.range(scaleOf(rig));
  double low = 0.0;
  for (int round = 0; round < 7; ++round) {
    ServoSecret trial = secret;
    trial.change_time *= static_cast<double>(quick.rows) / static_cast<double>(rig.rows);
    drawable.set(trial, magnitude);
    const double now = expectedGain(quick, trial);
    (now < gain ? low : high) = magnitude;
    // The added error grows with the square of a small magnitude; some effects begin at a threshold.
    const double ratio = gain / (1.0 - gain) / std::max(now / (1.0 - now), 1e-6);
    const double next = magnitude * std::sqrt(std::clamp(ratio, 0.02, 50.0));
    magnitude = next > low && next < high ? next : next >= high ? 0.5 * (magnitude + high) : 0.5 * (low + magnitude);
  }
  drawable.set(secret, magnitude);
  return magnitude;
}

double drawServoGain(std::mt19937_64& random) {
  std::uniform_real_distribution<double> u;
  return u(random) < 0.5 ? 0.05 + 0.05 * u(random) : 0.10 * std::pow(6.0, u(random));
}

std::string lawOf(const ServoRig& rig) { return rig.mechanism == kCable ? "classic" : "stribeck"; }

ServoDraw drawOne(const ServoDrawable& drawable, std::uint64_t seed) {
  std::mt19937_64 random(seed * 31 + 7);
  const std::size_t k = std::uniform_int_distribution<std::size_t>(0, drawable.on.size() - 1)(random);
  ServoDraw draw{{drawable.name}, {}, {}, drawServoRig(seed, drawable.on[k]), {}, 0.0};
  draw.law = lawOf(draw.rig);
  if (drawable.name == "stribeck") draw.law = "coulomb", draw.rig.breakaway = 1.0;
  drawServoDetails(draw.secret, draw.rig, random);
  draw.magnitude = servoMagnitude(drawable, drawServoGain(random), draw.rig, draw.secret);
  return draw;
}

}  // namespace

const std::vector<std::string>& servoEffects() {
  static const std::vector<std::string> names = servoNames(servoDrawables());
  return names;
}

const std::vector<std::string>& servoOutsideKinds() {
  static const std::vector<std::string> names = servoNames(servoOutside());
  return names;
}

ServoDraw drawServoNone(std::uint64_t seed, std::optional<Mechanism> mechanism) {
  std::mt19937_64 random(seed * 31 + 7);
  ServoDraw draw{{"none"}, {}, {}, drawServoRig(seed, mechanism.value_or(kAll[seed % kAll.size()])), {}, 0.0};
  draw.law = lawOf(draw.rig);
  drawServoDetails(draw.secret, draw.rig, random);
  return draw;
}

ServoDraw drawServoEffect(const std::string& effect, std::uint64_t seed) {
  return drawOne(findServoDrawable(servoDrawables(), effect), seed);
}

ServoDraw drawServoOutside(const std::string& kind, std::uint64_t seed) {
  ServoDraw draw = drawOne(findServoDrawable(servoOutside(), kind), seed);
  draw.effects = {"outside: " + kind};
  draw.channel = kind.starts_with("humidity") ? "humidity_percent"
                 : kind.starts_with("supply") ? "supply_V"
                                              : "neighbour_torque_Nm";
  return draw;
}

ServoDraw drawServoPair(std::uint64_t seed) {
  std::mt19937_64 random(seed * 31 + 7);
  const Mechanism mechanism = kAll[seed % kAll.size()];
  std::vector<const ServoDrawable*> possible;
  for (const ServoDrawable& d : servoDrawables()) {
    if (d.name != "stribeck" && std::ranges::find(d.on, mechanism) != d.on.end()) possible.push_back(&d);
  }
  std::ranges::shuffle(possible, random);
  ServoDraw draw{{}, {}, {}, drawServoRig(seed, mechanism), {}, 0.0};
  draw.law = lawOf(draw.rig);
  drawServoDetails(draw.secret, draw.rig, random);
  const ServoSecret details = draw.secret;
  for (int k = 0; k < 2; ++k) {
    ServoSecret alone = details;
    const double gain = 0.1 * std::pow(4.0, std::uniform_real_distribution<>()(random));
    possible[k]->set(draw.secret, servoMagnitude(*possible[k], gain, draw.rig, alone));
    draw.effects.push_back(possible[k]->name);
  }
  return draw;
}

std::optional<std::pair<std::string, double>> statedParameter(const ServoDraw& draw) {
  const ServoSecret& s = draw.secret;
  const std::map<std::string, std::pair<std::string, double>> stated = {
      {"coulomb-offset", {"n_c2", s.dry_offset}},
      {"static-offset", {"n_s2", s.static_offset}},
      {"load-dependence", {"n_c", s.load_share}},
      {"direction-asymmetry", {"a", s.direction_share}},
      {"viscous-asymmetry", {"k_asym", s.viscous_asymmetry * draw.rig.viscous}},
      {"inertia", {"J", s.inertia}},
      {"joint-gravity", {"mgl", s.hidden_weight}},
      {"position-ripple", {"r", s.ripple_ratio}},
      {"current-bias", {"I_0", s.bias}},
      {"channel-delay", {"dt", s.delay}},
      {"backlash", {"play", s.backlash}}};
  const auto found = stated.find(draw.effects[0]);
  if (found == stated.end()) return std::nullopt;
  return found->second;
}

}  // namespace simgap::reality
