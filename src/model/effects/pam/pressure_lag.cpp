/// \file
/// The pressure in the muscle follows the logged one late, through a valve or a hose:
///
///     f = z g(e),   tau dz/dt = p - z,
///
/// z solved exactly for a pressure that changes linearly between rows. Every session begins settled.
#include "model/effects/relaxation.h"
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::pressure_lag {
namespace {

constexpr EffectParameter kParameters[] = {{"tau", "s", 0.0, 1e2, 0.0, 0.0}};

/// z = p - y with dy/dt = dp/dt - y / tau: what has not arrived yet is what a Maxwell branch holds.
void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  if (p[0] > 0.0) terms.pressure -= maxwellBranch(rows, p[0], terms.pressure);
}

std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  std::vector<std::vector<double>> list;
  for (const double steps : {1.0, 4.0, 16.0, 64.0}) list.push_back({steps * rows.step});
  return list;
}

/// Less is between two samples; what is as slow as a session is a drift.
bool counts(std::span<const double> p, const ActuatorRows& rows) {
  constexpr double kLeast = 0.75;  // time steps, as of a channel's delay
  return p[0] > kLeast * rows.step && p[0] < kLongestRelaxation * longestSession(rows);
}

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kTime};

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "pressure-lag",
    .kind = ActuatorKind::kPam,
    .cause = "the force follows the logged pressure late: through a valve, a hose, or because it is logged late",
    .equation = "f = z g(e), tau dz/dt = p - z",
    .signature = "force overshoots the model after every fall of the pressure and falls short after every rise",
    .source = "first-order filling of a volume through a restriction",
    .look_alikes = "muscle-creep, contraction-hysteresis; a force that is logged late, where the length moves slowly",
    .separates =
        "steps of pressure at a fixed length, and fast strokes at a fixed pressure, which a late force is late "
        "for, too",
    .parameters = kParameters,
    .needs = kNeeds,
    .remembers = true,
    .needs_all_rows = true,
    .apply = apply,
    .starts = starts,
    .counts = counts,
};

}  // namespace simgap::actuator_effects::pressure_lag
