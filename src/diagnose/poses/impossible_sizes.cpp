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

/// Nobody misses what is so far askew: something else looks like it. For a base that is a tether or a hose which pulls,
/// for markers it is exchanged columns. \param most  [rad] that is not seen  \param what, how  before and behind the
/// angle
std::string visible(double turn, double most, const char* what, const char* how) {
  return turn <= most ? "" : fmt::format("{} {:.0f} deg {} would be seen", what, toDegrees(turn), how);
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
  const double turn = tiltOf(extension.parameters);  // where its parameters are one
  if (effect.gravity != nullptr) return visible(turn, 0.5, "a base that is", "off level");
  if (effect.marker_turn != nullptr) return visible(turn, 0.35, "markers that are", "askew on their body");
  if (effect.hinge_axis != nullptr) return visible(turn, 0.4, "an axis that is", "aslant");
  if (effect.joint_torque != nullptr) {
    const auto joint = std::ranges::find(model.joints, extension.target, &Joint::name);
    if (joint != model.joints.end()) return pushedAway(*joint, extension.parameters.front());
  }
  return effect.mass ? bodyOfNoMass(model) : "";
}

}  // namespace simgap
