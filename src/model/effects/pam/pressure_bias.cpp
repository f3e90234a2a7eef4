/// \file
/// An offset of the pressure sensor: f = (p - p0) g(e).
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::pressure_bias {
namespace {

constexpr EffectParameter kParameters[] = {{"p0", "Pa", -5e5, 5e5, 0.0, 0.0}};

void apply(std::span<const double> p, const ActuatorRows& /*rows*/, ActuatorTerms& terms) { terms.pressure -= p[0]; }

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "pressure-bias",
    .kind = ActuatorKind::kPam,
    .cause = "the pressure sensor has an offset",
    .equation = "f = (p - p0) g(e)",
    .signature = "the force is 0 before, or after, the pressure is; a residual in proportion to g(e)",
    .source = "catalogue of causes",
    .look_alikes = "pressure-threshold: the same equation while it lowers the pressure",
    .separates = "the pressure sensor's reading with the muscle vented",
    .parameters = kParameters,
    .apply = apply,
};

}  // namespace simgap::actuator_effects::pressure_bias
