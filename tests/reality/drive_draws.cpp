#include "reality/drive_draws.h"

#include <cmath>
#include <functional>
#include <map>
#include <random>
#include <stdexcept>

namespace simgap::reality {
namespace {

using Setter = std::function<void(DriveSecret&, double)>;

struct Drawable {
  std::string name;
  double guess;  ///< magnitude to begin with
  Setter set;
};

const std::vector<Drawable>& drawables() {
  static const std::vector<Drawable> list = {
      {"coulomb-offset", 0.3, [](DriveSecret& s, double m) { s.coulomb_offset = m; }},
      {"static-offset", 0.5, [](DriveSecret& s, double m) { s.static_offset = m; }},
      {"load-nonlinearity", 0.01, [](DriveSecret& s, double m) { s.load_quadratic = m; }},
      {"direction-asymmetry", 0.1, [](DriveSecret& s, double m) { s.direction_share = m; }},
      {"backdrive-asymmetry", 0.2, [](DriveSecret& s, double m) { s.backdrive_share = m; }},
      {"viscous-nonlinearity", 0.5, [](DriveSecret& s, double m) { s.viscous_bend = m; }},
      {"inertia", 0.003, [](DriveSecret& s, double m) { s.inertia = m; }},
      {"joint-gravity", 0.3, [](DriveSecret& s, double m) { s.hidden_weight = m; }},
      {"bend-friction", 0.1, [](DriveSecret& s, double m) { s.capstan = m; }},
      {"position-ripple", 0.15, [](DriveSecret& s, double m) { s.ripple = m; }},
      {"presliding-hysteresis", 0.5, [](DriveSecret& s, double m) { s.bristle_travel = 0.02 + m; }},
      {"stiction-ageing", 0.3, [](DriveSecret& s, double m) { s.ageing = m; }},
      {"friction-heating", 0.02,
       [](DriveSecret& s, double m) {
         s.viscous_heating = m;
         s.dry_heating = m / 3.0;
       }},
      {"torque-constant-heating", 0.003, [](DriveSecret& s, double m) { s.magnet_heating = m; }},
      {"torque-saturation", 0.0003, [](DriveSecret& s, double m) { s.saturation = m; }},
      {"current-bias", 0.1, [](DriveSecret& s, double m) { s.current_bias = m; }},
      {"torque-bias", 0.15, [](DriveSecret& s, double m) { s.torque_bias = m; }},
      {"channel-delay", 0.03, [](DriveSecret& s, double m) { s.delay = m; }},
      {"regime-change", 0.15, [](DriveSecret& s, double m) { s.change_share = m; }},
      {"torque-sensor-nonlinearity", 0.003, [](DriveSecret& s, double m) { s.gauge_bend = m; }},
      {"load-delay", 0.03, [](DriveSecret& s, double m) { s.sensor_filter = m; }}};
  return list;
}

const std::vector<Drawable>& outside() {
  static const std::vector<Drawable> list = {
      {"humidity-friction", 0.1, [](DriveSecret& s, double m) { s.humid_friction = m; }},
      {"humidity-current", 0.1, [](DriveSecret& s, double m) { s.humid_current = m; }},
      {"humidity-threshold", 0.2, [](DriveSecret& s, double m) { s.humid_threshold = m; }},
      {"humidity-angle", 0.1, [](DriveSecret& s, double m) { s.humid_angle = m; }},
      {"vibration-friction", 0.3, [](DriveSecret& s, double m) { s.vibration = m; }}};
  return list;
}

const Drawable& find(const std::vector<Drawable>& list, const std::string& name) {
  for (const Drawable& d : list) {
    if (d.name == name) return d;
  }
  throw std::runtime_error("no such secret: " + name);
}

std::vector<std::string> namesOf(const std::vector<Drawable>& list) {
  std::vector<std::string> names;
  for (const Drawable& d : list) names.push_back(d.name);
  return names;
}

/// Details that the magnitude does not set: when, where, which ratio.
void drawDetails(DriveSecret& secret, const DriveRig& rig, std::mt19937_64& random) {
  std::uniform_real_distribution<double> u;
  secret.hidden_angle = -1.2 + 2.4 * u(random);
  secret.ripple_ratio = 8.0 + 72.0 * u(random);
  secret.change_time = static_cast<double>(rig.rows) / rig.rate * (0.25 + 0.5 * u(random));
  secret.bristle_travel = 0.005 + 0.02 * u(random);
}

/// The magnitude at which a model of the secret would gain `gain`.
double magnitudeFor(const Drawable& drawable, double gain, const DriveRig& rig, DriveSecret& secret) {
  DriveRig quick = rig;
  quick.rows = std::min<std::size_t>(rig.rows, 12000);
  double magnitude = drawable.guess;
  for (int round = 0; round < 5; ++round) {
    DriveSecret trial = secret;
    trial.change_time *= static_cast<double>(quick.rows) / static_cast<double>(rig.rows);
    drawable.set(trial, magnitude);
    const double now = expectedGain(quick, trial);
    // The added error grows with the square of a small magnitude.
    const double ratio = gain / (1.0 - gain) / std::max(now / (1.0 - now), 1e-6);
    magnitude *= std::pow(std::min(std::max(ratio, 0.02), 50.0), 0.5);
  }
  drawable.set(secret, magnitude);
  return magnitude;
}

double drawGain(std::mt19937_64& random) {
  std::uniform_real_distribution<double> u;
  return u(random) < 0.5 ? 0.05 + 0.05 * u(random) : 0.10 * std::pow(6.0, u(random));
}

}  // namespace

const std::vector<std::string>& drawableEffects() {
  static const std::vector<std::string> names = namesOf(drawables());
  return names;
}

const std::vector<std::string>& outsideKinds() {
  static const std::vector<std::string> names = namesOf(outside());
  return names;
}

DriveRig drawRig(std::uint64_t seed) {
  std::mt19937_64 random(seed * 7919 + 17);
  std::uniform_real_distribution<double> u;
  DriveRig rig;
  rig.torque_per_ampere = 0.8 + 0.8 * u(random);
  rig.sliding = 0.18 + 0.2 * u(random);
  rig.breakaway = rig.sliding + 0.05 + 0.15 * u(random);
  rig.viscous = 0.006 + 0.024 * u(random);
  rig.stribeck_speed = 3.0 + 9.0 * u(random);
  rig.stribeck_power = 0.8 + 1.0 * u(random);
  rig.current_noise = 0.15 + 0.2 * u(random);
  rig.current_memory = 0.7 * u(random);
  rig.velocity_noise = 0.05 + 0.2 * u(random);
  rig.torque_noise = 0.01 + 0.04 * u(random);
  rig.rows = static_cast<std::size_t>(20000 + 20000 * u(random));
  rig.largest_load = 8.0 + 12.0 * u(random);
  rig.seed = seed;
  return rig;
}

DriveDraw drawNone(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  DriveDraw draw{{"none"}, {}, 0.0, drawRig(seed), {}, 0.0};
  drawDetails(draw.secret, draw.rig, random);
  return draw;
}

DriveDraw drawEffect(const std::string& effect, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  DriveDraw draw{{effect}, {}, drawGain(random), drawRig(seed), {}, 0.0};
  drawDetails(draw.secret, draw.rig, random);
  draw.magnitude = magnitudeFor(find(drawables(), effect), draw.gain, draw.rig, draw.secret);
  return draw;
}

DriveDraw drawPair(std::uint64_t seed) {
  std::mt19937_64 random(seed);
  DriveDraw draw{{}, {}, 0.0, drawRig(seed), {}, 0.0};
  drawDetails(draw.secret, draw.rig, random);
  std::uniform_int_distribution<std::size_t> pick(0, drawables().size() - 1);
  const std::size_t first = pick(random);
  std::size_t second = pick(random);
  while (second == first) second = pick(random);
  for (const std::size_t k : {first, second}) {
    const Drawable& drawable = drawables()[k];
    DriveSecret alone;
    drawDetails(alone, draw.rig, random);
    alone.hidden_angle = draw.secret.hidden_angle;
    alone.ripple_ratio = draw.secret.ripple_ratio;
    alone.change_time = draw.secret.change_time;
    drawable.set(draw.secret, magnitudeFor(drawable, 0.1 * std::pow(4.0, std::uniform_real_distribution<>()(random)),
                                           draw.rig, alone));
    draw.effects.push_back(drawable.name);
  }
  return draw;
}

std::optional<std::pair<std::string, double>> statedParameter(const DriveDraw& draw) {
  const DriveSecret& s = draw.secret;
  const std::map<std::string, std::pair<std::string, double>> stated = {
      {"coulomb-offset", {"n_c2", s.coulomb_offset}},
      {"static-offset", {"n_s2", s.static_offset}},
      {"load-nonlinearity", {"n_2", s.load_quadratic}},
      {"direction-asymmetry", {"a", s.direction_share}},
      {"backdrive-asymmetry", {"b", s.backdrive_share}},
      {"viscous-nonlinearity", {"m", 1.0 + s.viscous_bend}},
      {"inertia", {"J", s.inertia}},
      {"joint-gravity", {"mgl", s.hidden_weight}},
      {"bend-friction", {"mu", s.capstan}},
      {"position-ripple", {"r", s.ripple_ratio}},
      {"stiction-ageing", {"c", s.ageing}},
      {"friction-heating", {"beta_viscous", s.viscous_heating}},
      {"torque-saturation", {"s", s.saturation}},
      {"current-bias", {"I_0", s.current_bias}},
      {"torque-bias", {"tau_0", s.torque_bias}},
      {"channel-delay", {"dt", s.delay}},
      {"regime-change", {"a", s.change_share}},
      {"torque-sensor-nonlinearity", {"c", s.gauge_bend}},
      {"load-delay", {"dt", s.sensor_filter}}};
  const auto found = stated.find(draw.effects[0]);
  if (found == stated.end()) return std::nullopt;
  return found->second;
}

DriveDraw drawOutside(const std::string& kind, std::uint64_t seed) {
  std::mt19937_64 random(seed);
  DriveDraw draw{{"outside: " + kind},
                 kind.starts_with("vibration") ? "vibration_g" : "humidity_percent",
                 drawGain(random) + 0.05,
                 drawRig(seed),
                 {},
                 0.0};
  drawDetails(draw.secret, draw.rig, random);
  draw.magnitude = magnitudeFor(find(outside(), kind), draw.gain, draw.rig, draw.secret);
  return draw;
}

}  // namespace simgap::reality
