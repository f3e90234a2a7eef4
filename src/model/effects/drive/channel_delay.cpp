/// \file
/// The effort is logged later (or earlier) than the motion by dt: effort(t) belongs to the motion at t - dt.
#include "model/effects/delays.h"

namespace simgap::actuator_effects::channel_delay {
namespace {

constexpr EffectParameter kParameters[] = {delays::kDelay};

void apply(std::span<const double> p, const ActuatorRows& /*rows*/, ActuatorTerms& terms) { terms.delay += p[0]; }

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "channel-delay",
    .cause = "the current, voltage or force is logged at another moment than the motion",
    .equation = "I(t) from the motion at t - dt",
    .signature = "spikes of both signs at every reversal; less than three quarters of a sampling step is not named",
    .source = "catalogue of causes",
    .look_alikes = "load-delay, presliding-hysteresis, inertia",
    .separates = "fast reversals under load, and a knock that all channels see",
    .parameters = kParameters,
    .remembers = true,
    .needs_all_rows = true,
    .on_robot = true,
    .kin = "late channel",
    .on_gearbox = false,
    .apply = apply,
    .starts = delays::starts,
    .counts = delays::counts,
};

}  // namespace simgap::actuator_effects::channel_delay
