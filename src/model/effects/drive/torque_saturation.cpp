/// \file
/// Torque per ampere that falls at high current: effort = I + s I^3, I what an unsaturated motor would draw.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects {
namespace {

constexpr EffectParameter kParameters[] = {{"s", "1_A2", -0.1, 1.0, 0.0, 0.0}};

void apply(std::span<const double> p, const ActuatorRows& /*rows*/, ActuatorTerms& terms) { terms.cubic += p[0]; }

}  // namespace

extern const ActuatorEffect torque_saturation;
const ActuatorEffect torque_saturation = {
    .name = "torque-saturation",
    .cause = "the motor gives less torque per ampere or volt where it draws much",
    .equation = "I + s I^3",
    .signature = "the largest efforts are larger than the model, as their cube",
    .source = "catalogue of causes",
    .look_alikes = "load-nonlinearity, viscous-nonlinearity",
    .separates = "the largest loads in both directions, held still and moving",
    .parameters = kParameters,
    .apply = apply,
};

}  // namespace simgap::actuator_effects
