/// \file
/// An offset of the force sensor, or a weight that hangs on it: f + f0.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::force_bias {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "f0", .unit = "N", .torque = false}};

void fill(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = 1.0;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "force-bias",
    .kind = ActuatorKind::kPam,
    .cause = "the force sensor has an offset, or a weight hangs on it",
    .equation = "f + f0",
    .signature = "a constant residual, also without pressure",
    .source = "catalogue of causes",
    .look_alikes = "pressure-threshold at one length",
    .separates = "the force sensor's reading with the muscle vented and slack",
    .columns = kColumns,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::force_bias
