/// \file
/// Friction that falls as the drive warms up: viscous and dry friction x exp(-beta (T - T_mean)), a beta for each.
/// Where no temperature is logged, a first-order warm-up 1 - exp(-t / t_warm) of the whole log stands for it.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects {
namespace {

constexpr EffectParameter kParameters[] = {{"beta_viscous", "1", -2.0, 2.0, 0.0, 0.0},
                                           {"beta_dry", "1", -2.0, 2.0, 0.0, 0.0},
                                           {"T_mean", "degC", -1e9, 1e9, 0.0, 0.0, EffectParameter::Kind::kConstant},
                                           {"t_warm", "s", 1.0, 1e6, 1.0, 1.0, EffectParameter::Kind::kShape}};

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  Eigen::ArrayXd warmth;
  if (rows.temperature.size() > 0) {
    warmth = rows.temperature - p[2];
  } else {
    warmth = 1.0 - (-(rows.time - rows.time[0]) / p[3]).exp();
  }
  terms.viscous *= (-p[0] * warmth).max(-20.0).min(20.0).exp();
  terms.dry *= (-p[1] * warmth).max(-20.0).min(20.0).exp();
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  if (rows.temperature.size() > 0) return {{0.0, 0.0, rows.temperature.mean(), 1.0}};
  const double length = rows.time[rows.rows() - 1] - rows.time[0];
  return {{0.05, 0.05, 0.0, 0.1 * length}, {0.05, 0.05, 0.0, 0.4 * length}, {0.05, 0.05, 0.0, 2.0 * length}};
}

}  // namespace

extern const ActuatorEffect friction_heating;
const ActuatorEffect friction_heating = {
    .name = "friction-heating",
    .cause = "friction falls as the drive warms up",
    .equation = "tau_dry exp(-beta_dry (T - T_mean)), k_v exp(-beta_viscous (T - T_mean))",
    .signature =
        "steps and slopes that shrink while the temperature rises; without a temperature channel, over a warm-up time",
    .source = "catalogue of causes; viscosity falls about exponentially with temperature",
    .look_alikes = "regime-change, torque-constant-heating",
    .separates = "the same motion while the temperature goes up and while it goes down again",
    .parameters = kParameters,
    .apply = apply,
    .starts = starts,
};

}  // namespace simgap::actuator_effects
