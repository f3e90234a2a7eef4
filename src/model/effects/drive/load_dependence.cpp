/// \file
/// Friction that grows with the load, for laws without such a term: + n_c |tau_ext| (003 eq. 7), or, where it hardly
/// grows at small loads, + n_2 tau_ext^2 (servo gears: Duclusaud et al. 2024, their quadratic model).
#include "simgap/model/effects/actuator_effect.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap::actuator_effects::load_dependence {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kLoad};
constexpr EffectColumn kColumns[] = {{"n_c", "1", 0.0}};
constexpr EffectColumn kQuadraticColumns[] = {{"n_2", "1_Nm", 0.0}};

void fill(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.load.abs() * terms.dry;
}

void fillQuadratic(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
                   const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.load.square() * terms.dry;
}

bool containedIn(const FrictionLaw& law) { return law.needsLoad(); }

constexpr ActuatorEffect kUsual = {
    .name = "load-dependence",
    .form = "linear",
    .cause = "friction that grows with the load",
    .equation = "tau_fr += n_c |tau_ext| sign(w)",
    .signature = "steps at reversals that grow with the load",
    .source = "003 eq. 7",
    .look_alikes = "load-nonlinearity, bend-friction",
    .separates = "the same motion under several loads",
    .columns = kColumns,
    .needs = kNeeds,
    .contained_in = containedIn,
    .on_robot = true,
    .kin = "friction by load or angle",
    .on_gearbox = false,
    .fill = fill,
};

constexpr ActuatorEffect kQuadratic = [] {
  ActuatorEffect effect = kUsual;
  effect.form = "quadratic";
  effect.equation = "tau_fr += n_2 tau_ext^2 sign(w)";
  effect.columns = kQuadraticColumns;
  effect.fill = fillQuadratic;
  return effect;
}();
constexpr const ActuatorEffect* kForms[] = {&kQuadratic};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = withForms(kUsual, kForms);

}  // namespace simgap::actuator_effects::load_dependence
