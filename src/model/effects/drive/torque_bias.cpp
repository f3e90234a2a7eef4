/// \file
/// An offset of the torque sensor: tau_ext + tau_0, which also sets the friction.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::torque_bias {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kLoadSensor};
constexpr EffectParameter kParameters[] = {{"tau_0", "Nm", -1e4, 1e4, 0.0, 0.0}};

void apply(std::span<const double> p, const ActuatorRows& /*rows*/, ActuatorTerms& terms) { terms.load += p[0]; }

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "torque-bias",
    .cause = "the torque sensor has an offset",
    .equation = "tau_ext + tau_0",
    .signature = "a constant residual, and friction that has its minimum beside zero load",
    .source = "catalogue of causes",
    .look_alikes = "current-bias, joint-gravity, direction-asymmetry",
    .separates = "rows with nothing attached to the sensor, and loads that pass through zero",
    .parameters = kParameters,
    .needs = kNeeds,
    .is_bias = true,
    .apply = apply,
};

}  // namespace simgap::actuator_effects::torque_bias
