/// \file
/// Friction that grows with the load (003 eq. 7), for laws without that term: + n_c |tau_ext|.
#include "simgap/model/effects/actuator_effect.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap::actuator_effects::load_dependence {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kLoad};
constexpr EffectColumn kColumns[] = {{"n_c", "1", 0.0}};

void fill(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.load.abs() * terms.dry;
}

bool containedIn(const FrictionLaw& law) { return law.needsLoad(); }

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "load-dependence",
    .cause = "friction that grows with the load",
    .equation = "tau_fr += n_c |tau_ext| sign(w)",
    .signature = "steps at reversals that grow with the load",
    .source = "003 eq. 7",
    .look_alikes = "load-nonlinearity, bend-friction",
    .separates = "the same motion under several loads",
    .columns = kColumns,
    .needs = kNeeds,
    .contained_in = containedIn,
    .on_gearbox = false,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::load_dependence
