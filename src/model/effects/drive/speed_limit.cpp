/// \file
/// Voltage headroom: near the speed at which the back-EMF eats the supply, what is commanded grows without effect. The
/// logged effort then exceeds what the motion needs by a term that sets in at a speed w_limit:
///
///     effort += c max(0, |w| - w_limit) sign(w)
#include <algorithm>

#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::speed_limit {
namespace {

constexpr EffectParameter kParameters[] = {{"w_limit", "rad_s", 0.0, 1e6, 0.0, 0.0, EffectParameter::Kind::kScanned}};
constexpr EffectColumn kColumns[] = {{.name = "c", .unit = "A_s_rad", .lower = 0.0, .torque = false}};

void fill(std::span<const double> p, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = (rows.speed.abs() - p[0]).max(0.0) * rows.direction;
}

/// Knees in the upper half of the speeds: a limit is met, or it is none.
std::vector<std::vector<double>> starts(const ActuatorRows& rows, const Eigen::ArrayXd& /*residual*/) {
  std::vector<std::vector<double>> list;
  for (int k = 0; k < 10; ++k) list.push_back({rows.top_speed * (0.5 + 0.05 * k)});
  return list;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "speed-limit",
    .cause = "the supply limits the speed: beyond it more effort moves nothing faster",
    .equation = "effort += c max(0, |w| - w_limit) sign(w)",
    .signature = "nothing below a speed, then effort without motion",
    .source = "voltage headroom of a DC motor: V = R i + K_E w, |V| <= supply",
    .look_alikes = "viscous-nonlinearity, torque-saturation",
    .separates = "the same motion at a higher and at a lower supply voltage",
    .parameters = kParameters,
    .columns = kColumns,
    .fill = fill,
    .starts = starts,
};

}  // namespace simgap::actuator_effects::speed_limit
