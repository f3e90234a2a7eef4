#include <fmt/format.h>

#include <algorithm>
#include <cmath>

#include "simgap/core/error.h"
#include "simgap/fit/actuators/actuator_model.h"
#include "simgap/fit/actuators/bench_protocol.h"
#include "simgap/model/friction/friction_evaluation.h"

namespace simgap {
namespace {

constexpr double kMostProtocolRows = 1e6;

/// k_a, and what the law has.
std::vector<ParameterSpec> guessedParameters(const FrictionLaw& law) {
  std::vector<ParameterSpec> all{{"k_a", "Nm_A", 1e-12, kInfinity}};
  for (const ParameterSpec& p : termParameters(law, "Nm")) all.push_back(p);
  for (const ParameterSpec& p : stribeckParameters(law, 1.0, "rad_s")) all.push_back(p);
  return all;
}

/// A cause of which nothing is known yet: none of it, where it has a size, and its search's start elsewhere.
Extension unknownCause(const YamlNode& node) {
  const ActuatorEffect& effect = actuator_effects::find(node.text());
  if (!appliesTo(effect, ActuatorKind::kFriction)) node.fail(fmt::format("{} is no cause of a drive", effect.name));
  Extension cause{std::string(effect.name), "", {}, std::string(effect.form)};
  for (const EffectColumn& c : effect.columns) cause.parameters.push_back({std::string(c.name), std::string(c.unit)});
  for (const EffectParameter& p : effect.parameters) {
    cause.parameters.push_back({std::string(p.name), std::string(p.unit), p.start});
  }
  return cause;
}

/// Law and values of the file.
FittedModel guessOf(const YamlNode& root) {
  FittedModel guess;
  guess.kind = "friction";
  guess.law = root.at("law").text();
  const FrictionLaw& law = friction::find(guess.law);
  const YamlNode values = root.at("guess");
  for (const ParameterSpec& p : guessedParameters(law)) {
    const bool of_law = p.name != "k_a" && p.name != "v_s" && p.name != "delta";
    guess.parameters.push_back({p.name, p.unit, values.at(p.name).number(of_law ? kNonNegative : kPositive)});
  }
  return guess;
}

FittedModel checked(const FittedModel& fitted) {
  if (fitted.kind != "friction" || fitted.setting("effort_unit", "A") != "A" ||
      fitted.setting("load_unit", "Nm") != "Nm" || fitted.setting("predicts", "effort") != "effort") {
    throw ConfigError(
        "found a model of another kind with --drive, expected one of fit-friction or diagnose that predicts "
        "a drive's current from a torque");
  }
  return fitted;
}

}  // namespace

std::size_t DriveLimits::sessions() const { return static_cast<std::size_t>(std::floor(duration / session + 1e-9)); }
std::size_t DriveLimits::sessionRows() const { return static_cast<std::size_t>(std::llround(session * rate)); }

DriveLimits DriveLimits::read(const YamlNode& root, const FittedModel* fitted) {
  root.at("format").oneOf({"simgap/drive-limits/1"});
  DriveLimits limits;
  limits.session = root.findQuantity("session", "s", {2.0, 600.0, false, "2 to 600 s"}).value_or(limits.session);
  limits.duration = root.quantity("duration", "s",
                                  {limits.session, 1e5, false, "at least the length of a session, at most 100000 s"});
  limits.rate = root.findQuantity("rate", "Hz", {5.0, 1e4, false, "5 to 10000 Hz"}).value_or(limits.rate);
  if (limits.duration * limits.rate > kMostProtocolRows)
    root.fail("expected at most 1000000 rows (duration_s x rate_Hz)");
  const std::optional<YamlNode> ratio = root.find("transmission_ratio");
  limits.ratio = ratio ? ratio->number(kPositive) : 1.0;
  limits.lower = root.quantity("lower", "rad");
  limits.upper = root.quantity("upper", "rad");
  if (!(limits.lower < limits.upper)) {
    root.fail(fmt::format("found lower {:g} and upper {:g} rad, expected the lower below", limits.lower, limits.upper));
  }
  limits.velocity = root.quantity("velocity", "rad_s", kPositive);
  limits.acceleration = root.quantity("acceleration", "rad_s2", kPositive);
  limits.torque = root.quantity("torque", "Nm", kPositive);
  limits.current = root.quantity("current", "A", kPositive);
  limits.hangs = root.findQuantity("angle_offset", "rad").value_or(0.0);
  const YamlNode noise = root.at("noise");
  limits.noise = noise.quantity("current", "A", kPositive);
  if (const std::optional<YamlNode> memory = noise.find("memory")) {
    limits.memory = memory->number({0.0, 0.999, false, "0 to 0.999"});
  }
  for (const YamlNode& weight : root.at("weights").items()) {
    limits.weights.push_back({weight.quantity("mass", "kg", kNonNegative), weight.quantity("length", "m", kPositive)});
  }
  const bool none = std::ranges::all_of(limits.weights, [](const LeverWeight& w) { return w.mass == 0.0; });
  if (none) root.at("weights").fail("found no weight, expected one at least: without load no log tells k_a");
  if (fitted != nullptr && root.has("guess"))
    root.at("guess").fail("found values here and a fitted model, expected one");
  limits.guess = fitted != nullptr ? checked(*fitted) : guessOf(root);
  if (const std::optional<YamlNode> causes = root.find("causes")) {
    for (const YamlNode& node : causes->items()) {
      Extension cause = unknownCause(node);
      // Twice the same tells only a sum, and what a sum's parts are known by is nobody's business.
      if (std::ranges::count(limits.guess.extensions, cause.effect, &Extension::effect) > 0) {
        node.fail(fmt::format("found {} a second time, expected each cause once", cause.effect));
      }
      limits.guess.extensions.push_back(std::move(cause));
    }
  }
  root.expectAllRead();
  return limits;
}

BenchMotion::State BenchMotion::at(double time) const {
  if (kind == Kind::kSine) {
    const double rate = speed / amplitude, phase = rate * time;
    return {middle - amplitude * std::cos(phase), speed * std::sin(phase), speed * rate * std::cos(phase)};
  }
  const double ramp = speed / acceleration;            // [s] up to the speed
  const double move = 2.0 * amplitude / speed + ramp;  // the trapezoid's length
  const double phase = std::fmod(time, 2.0 * (move + rest));
  const bool forth = phase < move + rest;
  const double side = forth ? 1.0 : -1.0, t = std::min(forth ? phase : phase - move - rest, move);
  State way{-amplitude, 0.0, 0.0};  // from one end to the other
  if (t < ramp) {
    way = {-amplitude + 0.5 * acceleration * t * t, acceleration * t, acceleration};
  } else if (t <= move - ramp) {
    way = {-amplitude + speed * (t - 0.5 * ramp), speed, 0.0};
  } else if (t < move) {
    const double left = move - t;
    way = {amplitude - 0.5 * acceleration * left * left, acceleration * left, -acceleration};
  } else {
    way.angle = amplitude;
  }
  return {middle + side * way.angle, side * way.velocity, side * way.acceleration};
}

}  // namespace simgap
