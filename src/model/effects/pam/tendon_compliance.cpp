/// \file
/// The tendon stretches with force, so that the muscle contracts by more than the joint shows (002 section III):
///
/// e = eps + f / k
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::tendon_compliance {
namespace {

constexpr EffectParameter kParameters[] = {{"compliance", "1_N", 0.0, 1e-2, 0.0, 0.0}};

constexpr OwnParameter kOwn{.law = "spring", .law_without = "no-spring", .name = "k", .unit = "N", .inverse = true};

void apply(std::span<const double> p, const ActuatorRows& /*rows*/, ActuatorTerms& terms) {
  terms.contraction += p[0] * terms.effort;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "tendon-compliance",
    .kind = ActuatorKind::kPam,
    .cause = "the tendon stretches with force, so that the muscle contracts by more than the joint shows",
    .equation = "f = p g(eps + f / k), compliance = 1 / k",
    .signature = "force falls short of the model the more, the larger it is",
    .source = "002 section III, eq. 13-16",
    .look_alikes = "pressure-threshold and end-effect at one force level",
    .separates = "contraction at several pressures while the joint is held, with the muscle's own length measured",
    .parameters = kParameters,
    .implicit = true,
    .own_parameter = &kOwn,
    .apply = apply,
};

}  // namespace simgap::actuator_effects::tendon_compliance
