/// \file
/// Friction that falls with speed near zero (003 eq. 4), for laws without that term: + tau_s exp(-|w / v_s|^delta), or
/// + tau_s / (1 + |w / v_s|^delta), a Lorentzian for delta = 2.
#include "simgap/model/effects/actuator_effect.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap::actuator_effects::stribeck {
namespace {

constexpr EffectParameter kParameters[] = {{"v_s", "rad_s", 1e-3, 1e4, 1.0, 1.0, EffectParameter::Kind::kShape},
                                           {"delta", "1", 0.05, 20.0, 1.0, 1.0, EffectParameter::Kind::kShape}};
constexpr EffectColumn kColumns[] = {{"tau_s", "Nm", 0.0}, {"n_s", "1", 0.0}};

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  const Eigen::ArrayXd slow = (-(rows.speed.abs().max(1e-12) / p[0]).pow(p[1])).exp();
  x.col(0) = terms.dry * slow;
  x.col(1) = terms.load.abs() * terms.dry * slow;
}

void fillLorentzian(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& terms,
                    const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  const Eigen::ArrayXd slow = (1.0 + (rows.speed.abs().max(1e-12) / p[0]).pow(p[1])).inverse();
  x.col(0) = terms.dry * slow;
  x.col(1) = terms.load.abs() * terms.dry * slow;
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  std::vector<std::vector<double>> list;
  for (const double share : {0.01, 0.03, 0.1, 0.3}) list.push_back({share * rows.top_speed, 1.0});
  return list;
}

/// A curve that falls beyond all speeds of the log only bends the others: it is no Stribeck curve.
bool falls(std::span<const double> p, const ActuatorRows& rows) { return p[0] < 0.5 * rows.top_speed; }

bool containedIn(const FrictionLaw& law) { return law.hasStribeck(); }

constexpr ActuatorEffect kUsual = {
    .name = "stribeck",
    .form = "exponential",
    .cause = "friction that falls with speed near zero",
    .equation = "tau_fr += (tau_s + n_s |tau_ext|) exp(-|w / v_s|^delta) sign(w)",
    .signature = "effort above the model in slow motion, below it in fast motion, in both directions",
    .source = "003 eq. 4",
    .look_alikes = "static-offset, viscous-nonlinearity, presliding-hysteresis",
    .separates = "constant speeds between rest and a third of the top speed",
    .parameters = kParameters,
    .columns = kColumns,
    .contained_in = containedIn,
    .on_robot = true,
    .on_gearbox = false,
    .fill = fill,
    .starts = starts,
    .counts = falls,
};

constexpr ActuatorEffect kLorentzian = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "Lorentzian";
  effect.equation = "tau_fr += (tau_s + n_s |tau_ext|) / (1 + |w / v_s|^delta) sign(w)";
  effect.fill = fillLorentzian;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kLorentzian};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::stribeck
