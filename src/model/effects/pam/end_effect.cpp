/// \file
/// The sleeve's ends are no cylinder: the contraction that counts is larger at low pressure (Tondu & Lopez 2000):
///
///     e -> e (1 + s exp(-p / p_e))
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::end_effect {
namespace {

constexpr EffectParameter kParameters[] = {{"s", "1", 0.0, 1.0, 0.0, 0.0},
                                           {"p_e", "Pa", 5e3, 5e5, 1e5, 1e5, EffectParameter::Kind::kShape}};

void apply(std::span<const double> p, const ActuatorRows& /*rows*/, ActuatorTerms& terms) {
  terms.contraction *= 1.0 + p[0] * (-terms.pressure / p[1]).exp();
}

std::vector<std::vector<double>> starts(const ActuatorRows& /*rows*/, const Eigen::ArrayXd& /*residual*/) {
  return {{0.1, 4e4}, {0.1, 1.5e5}};
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "end-effect",
    .kind = ActuatorKind::kPam,
    .cause = "the muscle's ends are no cylinder, so that the contraction that counts depends on pressure",
    .equation = "f = p g(e (1 + s exp(-p / p_e)))",
    .signature = "a residual over contraction that is there at low pressure only",
    .source = "Tondu & Lopez 2000",
    .look_alikes = "pressure-threshold; without pressure dependence it is absorbed by a and b exactly",
    .separates = "force against length at a low and at a high pressure over the whole contraction",
    .parameters = kParameters,
    .apply = apply,
    .starts = starts,
};

}  // namespace simgap::actuator_effects::end_effect
