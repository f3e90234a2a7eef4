/// \file
/// Friction that grows faster or slower than the load: + n_2 tau_ext^2 beside a law's term in proportion to it. A law
/// without that term has nothing that this could be faster than: there it is a form of load-dependence.
#include "simgap/model/effects/actuator_effect.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap::actuator_effects::load_nonlinearity {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kLoad};
constexpr EffectColumn kColumns[] = {{"n_2", "1_Nm"}};

void fill(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.load.square() * terms.dry;
}

bool withoutMeaning(const FrictionLaw& law) { return !law.needsLoad(); }

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "load-nonlinearity",
    .cause = "friction that grows faster or slower than the load",
    .equation = "tau_fr += n_2 tau_ext^2 sign(w)",
    .signature = "residual x direction bends over the load",
    .source = "catalogue of causes; the next term of a series in the load",
    .look_alikes = "coulomb-offset, torque-saturation",
    .separates = "the same motion under at least four loads from zero to the largest",
    .columns = kColumns,
    .needs = kNeeds,
    .contained_in = withoutMeaning,
    .kin = "friction by load or angle",
    .fill = fill,
};

}  // namespace simgap::actuator_effects::load_nonlinearity
