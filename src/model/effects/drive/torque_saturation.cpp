/// \file
/// Torque per ampere that falls at high current: effort = I + s I^3, I what an unsaturated motor would draw, or from a
/// knee on effort = I + s (|I| - I_knee) sign(I). Of a duty or a set voltage U: what a supply with a resistance gives
/// falls with the current, which is what the voltage leaves beside the back-EMF: U = effort (1 - s (U - k_v w) sign U).
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::torque_saturation {
namespace {

constexpr EffectParameter kParameters[] = {{"s", "1_A2", 0.0, 1.0, 0.0, 0.0}};

constexpr EffectParameter kKneeParameters[] = {{"s", "1", 0.0, 5.0, 0.0, 0.0},
                                               {"I_knee", "A", 0.0, 1e6, 0.0, 0.0, EffectParameter::Kind::kShape}};

constexpr EffectParameter kSupplyParameters[] = {{"s", "1_A", 0.0, 1.0, 0.0, 0.0}};

void apply(std::span<const double> p, const ActuatorRows& /*rows*/, ActuatorTerms& terms) {
  terms.saturation.cubic += p[0];
}

void applySupply(std::span<const double> p, const ActuatorRows& /*rows*/, ActuatorTerms& terms) {
  terms.saturation.sag += p[0];
}

void applyKnee(std::span<const double> p, const ActuatorRows& /*rows*/, ActuatorTerms& terms) {
  terms.saturation.excess += p[0];
  terms.saturation.knee = p[1];
}

std::vector<std::vector<double>> kneeStarts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  std::vector<std::vector<double>> list;
  const double top = rows.effort.abs().maxCoeff();
  for (const double share : {0.3, 0.5, 0.7}) list.push_back({0.05, share * top});
  return list;
}

/// What bends where hardly a row lies below is no knee: friction's curve bends there, too.
bool kneeCounts(std::span<const double> p, const ActuatorRows& rows) {
  constexpr double kFewestBelow = 0.25;
  return (rows.effort.abs() < p[1]).cast<double>().mean() >= kFewestBelow;
}

constexpr ActuatorEffect kUsual = {
    .name = "torque-saturation",
    .form = "cube",
    .cause = "the motor gives less torque per ampere or volt where it draws much",
    .equation = "I + s I^3",
    .signature = "the largest efforts are larger than the model, as their cube",
    .source = "catalogue of causes",
    .look_alikes = "load-nonlinearity, load-dependence, viscous-nonlinearity",
    .separates = "the largest loads in both directions, held still and moving",
    .parameters = kParameters,
    .apply = apply,
};

constexpr ActuatorEffect kKnee = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "knee";
  effect.equation = "I + s max(|I| - I_knee, 0) sign(I)";
  effect.parameters = kKneeParameters;
  effect.apply = applyKnee;
  effect.starts = kneeStarts;
  effect.counts = kneeCounts;
  return effect;
}();
constexpr ActuatorEffect kSupply = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "supply";
  effect.equation = "U / (1 - s (U - k_v w) sign(U))";
  effect.parameters = kSupplyParameters;
  effect.apply = applySupply;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kKnee, &kSupply};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::torque_saturation
