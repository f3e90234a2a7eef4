#include "impossible_sizes.h"

#include <fmt/format.h>

#include <algorithm>
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

/// Nor markers that stand so askew on their body: exchanged columns look like that.
std::string visibleTurn(double turn) {
  constexpr double kSeen = 0.35;  // [rad]
  return turn <= kSeen ? ""
                       : fmt::format("markers that are {:.0f} deg askew on their body would be seen", toDegrees(turn));
}

/// Nor a hinge that is mounted so far aslant.
std::string visibleAxis(double tilt) {
  constexpr double kSeen = 0.4;  // [rad]
  return tilt <= kSeen ? "" : fmt::format("an axis that is {:.0f} deg aslant would be seen", toDegrees(tilt));
}

/// What pushes a joint away from its rest is no skin, cable or stop; less than the model's own spring may be there.
std::string pushedAway(const Joint& joint, const Estimate& stiffness) {
  if (joint.spring_stiffness + stiffness.value >= 0.0) return "";
  return fmt::format("what pushes {} away from its rest, by {:.3g} Nm/rad, is nothing elastic", joint.name,
                     -stiffness.value);
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
  if (effect.marker_turn != nullptr) return visibleTurn(tiltOf(extension.parameters));
  if (effect.hinge_axis != nullptr) return visibleAxis(tiltOf(extension.parameters));
  if (effect.joint_torque != nullptr) {
    const auto joint = std::ranges::find(model.joints, extension.target, &Joint::name);
    if (joint != model.joints.end()) return pushedAway(*joint, extension.parameters.front());
  }
  return effect.mass ? bodyOfNoMass(model) : "";
}

}  // namespace simgap
