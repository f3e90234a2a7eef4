/// \file
/// A weight that the torque sensor does not see: load += mgl sin(theta - theta_0). Two coefficients of sine and cosine
/// would be equivalent, but the load also sets the friction.
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

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
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
};

}  // namespace simgap::actuator_effects::joint_gravity
