/// \file
/// The bladder takes up some pressure before the braid carries any: f = (p - p0) g(e).
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::pressure_threshold {
namespace {

constexpr EffectParameter kParameters[] = {{"p0", "Pa", 0.0, 5e5, 0.0, 0.0}};

void apply(std::span<const double> p, const ActuatorRows& /*rows*/, ActuatorTerms& terms) { terms.pressure -= p[0]; }

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "pressure-threshold",
    .kind = ActuatorKind::kPam,
    .cause = "the bladder's stiffness takes up the first of the pressure: no force below a threshold",
    .equation = "f = (p - p0) g(e)",
    .signature = "the force is 0 before the pressure is; a residual in proportion to g(e), whatever the pressure",
    .source = "Chou & Hannaford 1996",
    .look_alikes = "pressure-bias: the same equation, no log of force and pressure can tell them apart",
    .separates = "the pressure sensor's reading with the muscle vented, beside slow pressure ramps from there",
    .parameters = kParameters,
    .apply = apply,
};

}  // namespace simgap::actuator_effects::pressure_threshold
