/// \file
/// The load is logged later (or earlier) than motion and effort by dt, as the filter of a torque sensor's amplifier
/// makes it: what the drive works against at t is what is logged at t + dt.
#include <cmath>

#include "model/effects/delays.h"

namespace simgap::actuator_effects::load_delay {
namespace {

constexpr OptionalChannel kNeeds[] = {OptionalChannel::kLoadSensor, OptionalChannel::kTime};
constexpr EffectParameter kParameters[] = {delays::kDelay};

/// Between the two rows about that moment; where a session ends before it, as it is logged.
void apply(std::span<const double> p, const ActuatorRows& rows, ActuatorTerms& terms) {
  const double shift = p[0] / rows.step, whole = std::floor(shift), part = shift - whole;
  const auto by = static_cast<Eigen::Index>(whole);
  const Eigen::ArrayXd logged = terms.load;
  for (Eigen::Index i = 0; i < rows.rows(); ++i) {
    const Eigen::Index low = i + by, high = low + 1;
    if (low < 0 || high >= rows.rows() || rows.session[low] != rows.session[i] || rows.session[high] != rows.session[i])
      continue;
    terms.load[i] = (1.0 - part) * logged[low] + part * logged[high];
  }
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "load-delay",
    .cause = "the torque sensor's reading is logged at another moment than motion and effort: a filter, another clock",
    .equation = "tau_ext(t) as logged at t + dt",
    .signature =
        "a residual that goes with the slope of the load, at reversals as elsewhere; less than three quarters of "
        "a sampling step is not named",
    .source = "catalogue of causes",
    .look_alikes = "channel-delay, inertia, presliding-hysteresis",
    .separates = "the load knocked and swung while the drive holds still",
    .parameters = kParameters,
    .needs = kNeeds,
    .remembers = true,
    .needs_all_rows = true,
    .kin = "late channel",
    .on_gearbox = false,
    .apply = apply,
    .starts = delays::starts,
    .counts = delays::counts,
};

}  // namespace simgap::actuator_effects::load_delay
