/// \file
/// The sleeve's wall is rubber: a part of the force depends on the length alone, with or without pressure,
///
///     f -= k_w e
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::wall_stiffness {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "k_w", .unit = "N", .lower = 0.0, .torque = false}};

void fill(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& terms,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = -terms.contraction;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "wall-stiffness",
    .kind = ActuatorKind::kPam,
    .cause = "the rubber of the muscle's wall resists the change of length at any pressure",
    .equation = "f -= k_w e",
    .signature = "a residual over contraction that is the same at all pressures",
    .source = "Klute & Hannaford 2000",
    .look_alikes = "end-effect over a small range of pressures, force-bias at one length",
    .separates = "force against length with the muscle vented, and at a high pressure",
    .columns = kColumns,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::wall_stiffness
