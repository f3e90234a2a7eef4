/// \file
/// Dry friction that differs by the direction of motion: x (1 + a sign(w)).
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::direction_asymmetry {
namespace {

constexpr EffectParameter kParameters[] = {{"a", "1", -0.9, 0.9, 0.0, 0.0}};

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  terms.dry *= 1.0 + p[0] * rows.direction;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "direction-asymmetry",
    .cause = "dry friction that differs by the direction of motion",
    .equation = "tau_dry (1 + a sign(w))",
    .signature = "steps at reversals that differ by direction; looks like an offset that grows with the load",
    .source = "catalogue of causes",
    .look_alikes = "current-bias, torque-bias, backdrive-asymmetry",
    .separates = "both directions under large loads of both signs",
    .parameters = kParameters,
    .on_robot = true,
    .apply = apply,
};

}  // namespace simgap::actuator_effects::direction_asymmetry
