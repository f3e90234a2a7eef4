/// \file
/// A preload that acts in the static term only (003 eq. 11: what variant B adds): + n_s2 E.
#include "simgap/model/effects/actuator_effect.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap::actuator_effects::static_offset {
namespace {

constexpr EffectColumn kColumns[] = {{"n_s2", "Nm", 0.0}};

void fill(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
          const Eigen::ArrayXd& stribeck, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.dry * stribeck;
}

/// Without a Stribeck term nothing tells rest from sliding.
bool containedIn(const FrictionLaw& law) {
  return !law.hasStribeck() || law.hasTerm(FrictionBasis::kDirection, FrictionShape::kStatic);
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "static-offset",
    .cause = "a preload that makes breaking away harder, but not sliding",
    .equation = "tau_s += n_s2",
    .signature = "a step at reversals that is gone once the drive moves faster than v_s",
    .source = "003 eq. 11",
    .look_alikes = "coulomb-offset, stribeck, presliding-hysteresis",
    .separates = "very slow motion below v_s with the load near zero",
    .columns = kColumns,
    .contained_in = containedIn,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::static_offset
