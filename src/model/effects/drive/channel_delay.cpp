/// \file
/// The effort is logged later (or earlier) than the motion by dt: effort(t) belongs to the motion at t - dt.
#include "simgap/model/effects/actuator_effect.h"

#include <cmath>

namespace simgap::actuator_effects::channel_delay {
namespace {

constexpr EffectParameter kParameters[] = {{"dt", "s", -0.5, 0.5, 0.0, 0.0}};

void apply(std::span<const double> p, const ActuatorRows& /*rows*/, ActuatorTerms& terms) { terms.delay += p[0]; }

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  std::vector<std::vector<double>> list;
  for (int k = -10; k <= 10; ++k) {
    const double delay = (k + 0.37) * rows.step;  // off the samples, where the derivative jumps
    if (std::abs(delay) < 0.5) list.push_back({delay});
  }
  return list;
}

/// Where a reversal lies between two rows is not known better than to half a row, and a velocity from an encoder lags
/// by as much: such a delay is no finding, one of a whole row is.
bool counts(std::span<const double> p, const ActuatorRows& rows) { return std::abs(p[0]) >= 0.75 * rows.step; }

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
    .on_robot = true,
    .on_gearbox = false,
    .apply = apply,
    .starts = starts,
    .counts = counts,
};

}  // namespace simgap::actuator_effects::channel_delay
