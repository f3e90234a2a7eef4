/// \file
/// Friction that falls as the drive warms up: viscous and dry friction x exp(-beta (T - T_mean)), a beta for each, or
/// x 1 / (1 + beta (T - T_mean)) (the viscosity of some greases).
/// Where no temperature is logged, a first-order warm-up 1 - exp(-t / t_warm) stands for it, of the whole log or of
/// each session after a long pause.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::friction_heating {
namespace {

constexpr EffectParameter kParameters[] = {{"beta_viscous", "1", -10.0, 10.0, 0.0, 0.0},
                                           {"beta_dry", "1", -10.0, 10.0, 0.0, 0.0},
                                           {"T_mean", "degC", -1e9, 1e9, 0.0, 0.0, EffectParameter::Kind::kConstant},
                                           {"t_warm", "s", 1.0, 1e6, 100.0, 1.0, EffectParameter::Kind::kShape},
                                           {"cools", "1", 0.0, 1.0, 0.0, 0.0, EffectParameter::Kind::kConstant}};

/// [s] since the log began, or the session where it cools down between them.
Eigen::ArrayXd warmingTime(bool cools, const ActuatorRows& rows) {
  Eigen::ArrayXd time = rows.elapsed - rows.elapsed[0];
  if (!cools) return time;
  double begin = 0.0;
  for (Eigen::Index i = 1; i < time.size(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    if (rows.session[k] != rows.session[k - 1]) begin = time[i];
    time[i] -= begin;
  }
  return time;
}

Eigen::ArrayXd warmthOf(std::span<const double> p, const ActuatorRows& rows) {
  if (rows.temperature.size() > 0) return rows.temperature - p[2];
  return 1.0 - (-warmingTime(p[4] != 0.0, rows) / p[3]).exp();
}

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  const Eigen::ArrayXd warmth = warmthOf(p, rows);
  terms.viscous *= (-p[0] * warmth).max(-20.0).min(20.0).exp();
  terms.dry *= (-p[1] * warmth).max(-20.0).min(20.0).exp();
}

void applyHyperbolic(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  const Eigen::ArrayXd warmth = warmthOf(p, rows);
  terms.viscous /= (1.0 + p[0] * warmth).max(0.02);
  terms.dry /= (1.0 + p[1] * warmth).max(0.02);
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  if (rows.temperature.size() > 0) return {{0.0, 0.0, rows.temperature.mean(), 1.0, 0.0}};
  const double length = rows.elapsed[rows.rows() - 1] - rows.elapsed[0];
  std::vector<std::vector<double>> list;
  for (const double cools : {0.0, 1.0}) {
    if (cools != 0.0 && rows.session.front() == rows.session.back()) break;
    for (const double share : {0.1, 0.4, 2.0}) list.push_back({0.05, 0.05, 0.0, share * length, cools});
  }
  return list;
}

constexpr ActuatorEffect kUsual = {
    .name = "friction-heating",
    .form = "exponential",
    .cause = "friction falls as the drive warms up",
    .equation = "tau_dry exp(-beta_dry (T - T_mean)), k_v exp(-beta_viscous (T - T_mean))",
    .signature =
        "steps and slopes that shrink while the temperature rises; without a temperature channel, over a warm-up time",
    .source = "catalogue of causes; viscosity falls about exponentially with temperature",
    .look_alikes = "regime-change, torque-constant-heating",
    .separates = "the same motion while the temperature goes up and while it goes down again",
    .parameters = kParameters,
    .on_robot = true,
    .apply = apply,
    .starts = starts,
};

constexpr ActuatorEffect kHyperbolic = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "hyperbolic";
  effect.equation = "tau_dry / (1 + beta_dry (T - T_mean)), k_v / (1 + beta_viscous (T - T_mean))";
  effect.apply = applyHyperbolic;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kHyperbolic};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::friction_heating
