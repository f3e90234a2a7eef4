/// \file
/// Dry friction at zero load, from adhesion or preload: + n_c2 on the whole dry friction, or (sliding_only = 1) on
/// tau_c alone as in variant A (003 eq. 9). Both are this one cause; the data choose the form.
#include "simgap/model/effects/actuator_effect.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap::actuator_effects::coulomb_offset {
namespace {

constexpr EffectParameter kParameters[] = {{"sliding_only", "1", 0.0, 1.0, 0.0, 0.0, EffectParameter::Kind::kConstant}};
constexpr EffectColumn kColumns[] = {{"n_c2", "Nm", 0.0}};

void fill(std::span<const double> p, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
          const Eigen::ArrayXd& stribeck, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = terms.dry * (1.0 - p[0] * stribeck);
}

std::vector<std::vector<double>> starts(const ActuatorRows& /*rows*/, const Eigen::ArrayXd& /*residual*/) {
  return {{0.0}, {1.0}};
}

bool containedIn(const FrictionLaw& law) {
  return law.hasTerm(FrictionBasis::kDirection, FrictionShape::kSliding) ||
         law.hasTerm(FrictionBasis::kDirection, FrictionShape::kAlways);
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "coulomb-offset",
    .cause = "dry friction that is there without any load, from adhesion or preload",
    .equation = "tau_fr += n_c2 (1 - sliding_only E) sign(w)",
    .signature =
        "a step of the same height at every reversal, also without load; relative errors largest at small loads",
    .source = "003 eq. 9",
    .look_alikes = "static-offset, load-nonlinearity, current-bias",
    .separates = "slow and fast motion in both directions with the load near zero",
    .parameters = kParameters,
    .columns = kColumns,
    .contained_in = containedIn,
    .fill = fill,
    .starts = starts,
};

}  // namespace simgap::actuator_effects::coulomb_offset
