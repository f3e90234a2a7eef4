/// \file
/// Cable friction that grows with the wrap angle: dry friction x exp(mu (theta - theta_mean)) (capstan), or
/// x (1 + mu (theta - theta_mean)) where sheath and cable press on each other by the bend alone, or
/// x exp(mu |theta - theta_0|) of a cable that is straight at theta_0 and bent either way.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::bend_friction {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kJointAngle, OptionalChannel::kTurn};
constexpr EffectParameter kParameters[] = {
    {"mu", "1_rad", -3.0, 3.0, 0.0, 0.0}, {"theta_mean", "rad", -1e9, 1e9, 0.0, 0.0, EffectParameter::Kind::kConstant}};

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  terms.dry *= (p[0] * (rows.joint_angle - p[1])).max(-20.0).min(20.0).exp();
}

void applyLinear(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  terms.dry *= (1.0 + p[0] * (rows.joint_angle - p[1])).max(0.02);
}

constexpr EffectParameter kSymmetricParameters[] = {
    kParameters[0], {"theta_0", "rad", -100.0, 100.0, 0.0, 0.0, EffectParameter::Kind::kShape}};

void applySymmetric(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  terms.dry *= (p[0] * (rows.joint_angle - p[1]).abs()).max(-20.0).min(20.0).exp();
}

std::vector<std::vector<double>> symmetricStarts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  const double low = rows.joint_angle.minCoeff(), span = rows.joint_angle.maxCoeff() - low;
  return {{0.1, low + 0.35 * span}, {0.1, low + 0.65 * span}};
}

/// Straight within the angles of the log, else it is bent one way; and rubbing more where it is bent, not less.
bool isBentBothWays(std::span<const double> p, const ActuatorRows& rows) {
  return p[0] > 0.0 && p[1] > rows.joint_angle.minCoeff() && p[1] < rows.joint_angle.maxCoeff();
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  return {{0.0, rows.joint_angle.mean()}};
}

constexpr ActuatorEffect kUsual = {
    .name = "bend-friction",
    .form = "exponential",
    .cause = "cable friction that grows with the angle the cable is bent by",
    .equation = "tau_dry exp(mu (theta - theta_mean))",
    .signature = "steps at reversals that grow with the joint angle",
    .source = "capstan equation",
    .look_alikes = "joint-gravity, load-nonlinearity where load and angle go together",
    .separates = "the same load at joint angles far apart",
    .parameters = kParameters,
    .needs = kNeeds,
    .kin = "friction by load or angle",
    .apply = apply,
    .starts = starts,
};

constexpr ActuatorEffect kLinear = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "linear";
  effect.equation = "tau_dry (1 + mu (theta - theta_mean))";
  effect.apply = applyLinear;
  return effect;
}();
constexpr ActuatorEffect kSymmetric = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "symmetric";
  effect.equation = "tau_dry exp(mu abs(theta - theta_0))";
  effect.parameters = kSymmetricParameters;
  effect.apply = applySymmetric;
  effect.starts = symmetricStarts;
  effect.counts = isBentBothWays;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kLinear, &kSymmetric};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::bend_friction
