/// \file
/// An offset of the voltage's sensor, or of the current's, times R: V + V_0.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::voltage_bias {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "V_0", .unit = "V", .torque = false}};

void fill(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = 1.0;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "voltage-bias",
    .kind = ActuatorKind::kMotor,
    .cause = "the voltage is read with an offset, or the current is: I_0 = -V_0 / R",
    .equation = "V + V_0",
    .signature = "a constant residual, also at rest without a current",
    .source = "catalogue of causes",
    .look_alikes = "brush-drop where the current has one sign",
    .separates = "rows with the motor switched off, and currents of both signs",
    .columns = kColumns,
    .is_offset = true,
    .is_bias = true,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::voltage_bias
