/// \file
/// An offset of the current sensor: + I_0. While a drive moves, dry friction that differs by direction and not with the
/// load, tau_c + d forwards and tau_c - d backwards, is the same function; a motor switched off tells them apart.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::current_bias {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "I_0", .unit = "A", .torque = false}};

void fill(std::span<const double> /*p*/, const ActuatorRows& /*rows*/, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = 1.0;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "current-bias",
    .cause =
        "the current, voltage or force of the motor is read with an offset, or dry friction differs by direction by "
        "the same amount under every load",
    .equation = "I + I_0",
    .signature = "a constant residual",
    .source = "catalogue of causes",
    .look_alikes = "torque-bias, joint-gravity, direction-asymmetry",
    .separates = "rows with the motor switched off, and loads of both signs",
    .columns = kColumns,
    .is_offset = true,
    .is_bias = true,
    .on_robot = true,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::current_bias
