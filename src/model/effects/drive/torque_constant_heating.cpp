/// \file
/// Magnets that weaken as they warm: k_a (1 - alpha (T - T_mean)).
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::torque_constant_heating {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kTemperature, OptionalChannel::kLoad};
constexpr EffectParameter kParameters[] = {{"alpha", "1_K", -0.02, 0.02, 0.0, 0.0},
                                           {"T_mean", "degC", -1e9, 1e9, 0.0, 0.0, EffectParameter::Kind::kConstant}};

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  const Eigen::ArrayXd gain = (1.0 - p[0] * (rows.temperature - p[1])).max(0.05);
  terms.gain = terms.gain.size() > 0 ? Eigen::ArrayXd(terms.gain * gain) : gain;
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  return {{0.0, rows.temperature.mean()}};
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "torque-constant-heating",
    .cause = "the motor gives less torque per ampere as its magnets warm",
    .equation = "k_a (1 - alpha (T - T_mean))",
    .signature = "the effort per load, not the friction, follows the temperature",
    .source = "catalogue of causes",
    .look_alikes = "friction-heating, regime-change",
    .separates = "large loads in both directions while the temperature goes up and down",
    .parameters = kParameters,
    .needs = kNeeds,
    .apply = apply,
    .starts = starts,
};

}  // namespace simgap::actuator_effects::torque_constant_heating
