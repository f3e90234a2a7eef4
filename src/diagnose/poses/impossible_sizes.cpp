#include "impossible_sizes.h"

#include <fmt/format.h>

#include <cmath>

namespace simgap {
namespace {

/// A load of less than nothing is a body that is lighter than its file says, as long as there is a body left.
std::string bodyOfNoMass(const ArmModel& model) {
  ArmModel whole = model;
  applyToModel(resolveExtensions(model), whole);
  for (const Body& body : whole.bodies) {
    const double mass = massProperties(body).mass;
    if (mass < 0.0) return fmt::format("{} would have a mass of {:.3g} kg", body.name, mass);
  }
  return "";
}

/// Nobody misses a base that is so far from level: something else pulls, a tether or a hose.
std::string visibleTilt(double tilt) {
  constexpr double kSeen = 0.5;  // [rad]
  return tilt <= kSeen ? "" : fmt::format("a base that is {:.0f} deg off level would be seen", toDegrees(tilt));
}

}  // namespace

double tiltOf(std::span<const Estimate> turn) {
  double squared = 0.0;
  for (const Estimate& p : turn) squared += p.value * p.value;
  return std::sqrt(squared);
}

std::string impossibleSize(const PoseFit& fit, std::size_t cause) {
  const ArmModel model = fit.model();
  const std::size_t given = model.extensions.size() - fit.causes().size();
  const ArmEffect& effect = *fit.causes()[cause].effect;
  const Extension& extension = model.extensions[given + cause];
  for (std::size_t i = 0; i < effect.parameters.size(); ++i) {
    const ArmEffectParameter& parameter = effect.parameters[i];
    const double value = extension.parameters[i].value;
    if (!parameter.positive || value > 0.0) continue;
    const std::string unit = parameter.unit == "1" ? "" : " " + std::string(parameter.unit);
    return fmt::format("{} = {:.3g}{} is no physical size", parameter.name, value, unit);
  }
  if (effect.gravity != nullptr) return visibleTilt(tiltOf(extension.parameters));
  return effect.mass ? bodyOfNoMass(model) : "";
}

}  // namespace simgap
