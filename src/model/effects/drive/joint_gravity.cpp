/// \file
/// A weight that the torque sensor does not see: load += mgl sin(theta - theta_0). Two coefficients of sine and cosine
/// would be equivalent, but the load also sets the friction. Where the load that is known is a weight at the same
/// joint, as that of a pendulum is, k_a makes up for what pulls with it, and only what pulls across it can be told.
#include <cmath>
#include <optional>

#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::joint_gravity {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kJointAngle, OptionalChannel::kTurn};
constexpr EffectParameter kParameters[] = {{"mgl", "Nm", -1e4, 1e4, 0.0, 0.1},
                                           {"theta_0", "rad", -4.0, 4.0, 0.0, 0.0, EffectParameter::Kind::kShape}};

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  terms.load += p[0] * (rows.joint_angle - p[1]).sin();
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  std::vector<std::vector<double>> list;
  for (const double angle : {-1.2, 0.0, 1.2}) {
    for (const double sign : {-1.0, 1.0}) list.push_back({sign * 0.05 * rows.top_load, angle});
  }
  return list;
}

constexpr EffectParameter kAcrossParameters[] = {
    {"mgl_across", "Nm", -1e4, 1e4, 0.0, 0.1},
    {"theta_load", "rad", -4.0, 4.0, 0.0, 0.0, EffectParameter::Kind::kConstant}};

void applyAcross(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  terms.load += p[0] * (rows.joint_angle - p[1]).cos();
}

/// Where a load that is a weight at this joint does not pull: theta_load of A sin(theta - theta_load); none for others.
std::optional<double> angleOfLoad(const ActuatorRows& rows) {
  constexpr double kAll = 0.98;  // of the load's squares
  const Eigen::ArrayXd sine = rows.joint_angle.sin(), cosine = rows.joint_angle.cos();
  const double ss = sine.square().sum(), cc = cosine.square().sum(), sc = (sine * cosine).sum();
  const double along = (sine * rows.load).sum(), across = (cosine * rows.load).sum(), total = rows.load.square().sum();
  const double determinant = ss * cc - sc * sc;
  if (!(total > 0.0) || !(determinant > 1e-6 * ss * cc)) return std::nullopt;
  const double a = (cc * along - sc * across) / determinant, b = (ss * across - sc * along) / determinant;
  if (a * along + b * across < kAll * total) return std::nullopt;
  return std::atan2(-b, a);
}

/// Beside such a load the whole weight has no size.
bool isBesideNoWeight(std::span<const double> /*p*/, const ActuatorRows& rows) { return !angleOfLoad(rows); }

std::vector<std::vector<double>> acrossStarts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  const std::optional<double> angle = angleOfLoad(rows);
  if (!angle) return {};
  return {{-0.05 * rows.top_load, *angle}, {0.05 * rows.top_load, *angle}};
}

constexpr ActuatorEffect kUsual = {
    .name = "joint-gravity",
    .cause = "a weight that the torque sensor does not see",
    .equation = "tau_ext += m g l sin(theta - theta_0)",
    .signature = "a residual that is a sinusoid of the joint angle, the same in both directions",
    .source = "catalogue of causes",
    .look_alikes = "current-bias, torque-bias and inertia where the joint moves little",
    .separates = "slow motion over the widest range of joint angles",
    .parameters = kParameters,
    .needs = kNeeds,
    .of_angle = true,
    .apply = apply,
    .starts = starts,
    .counts = isBesideNoWeight,
};

constexpr ActuatorEffect kAcross = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "across";
  effect.equation = "tau_ext += mgl_across cos(theta - theta_load)";
  effect.parameters = kAcrossParameters;
  effect.apply = applyAcross;
  effect.starts = acrossStarts;
  effect.counts = nullptr;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kAcross};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::joint_gravity
