/// \file
/// Backlash or bristle compliance: after a reversal friction builds up over a travel (Dahl 1968),
///
///     dz/dx = (sign(w) - z) / x_s,     dry friction x z.
///
/// Every real drive has a little of it: the baseline carries it with a small x_s as a nuisance; the cause is a large
/// one.
#include "simgap/model/effects/actuator_effect.h"

#include <cmath>

namespace simgap::actuator_effects::presliding_hysteresis {
namespace {

constexpr EffectParameter kParameters[] = {{"x_s", "rad", 1e-6, 1e3, 0.0, 1.0, EffectParameter::Kind::kShape}};

void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  double z = rows.rows() > 0 ? rows.direction[0] : 0.0;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const double d = rows.direction[i];
    if (z != d) z = d + (z - d) * std::exp(-rows.travel[i] / p[0]);  // mostly it has built up
    terms.dry[i] *= z * d;
  }
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  const double stride = rows.top_speed * rows.step;
  return {{0.03 * stride}, {0.3 * stride}, {3.0 * stride}};
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "presliding-hysteresis",
    .cause = "after a reversal friction builds up over some travel: backlash or elastic bristles",
    .equation = "tau_dry z, dz/dx = (sign(w) - z) / x_s",
    .signature = "rounded instead of sharp steps after reversals, as long in travel at every speed",
    .remarks =
        "a little of it is in every drive: the baseline carries up to a tenth of the typical travel between two rows",
    .source = "Dahl 1968",
    .look_alikes = "channel-delay, stribeck, transmission-compliance",
    .separates = "slow reversals with many samples in the first travel after each",
    .parameters = kParameters,
    .remembers = true,
    .in_every_drive = true,
    .apply = apply,
    .starts = starts,
};

}  // namespace simgap::actuator_effects::presliding_hysteresis
