/// \file
/// An offset of the current sensor: + I_0.
#include "simgap/model/drive_effect.h"

namespace simgap::drive_effects {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "I_0", .unit = "A", .torque = false}};

void fill(std::span<const double> /*p*/, const DriveRows& /*rows*/, const DriveTerms& /*terms*/,
          const Eigen::ArrayXd& /*still*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = 1.0;
}

}  // namespace

extern const DriveEffect current_bias;
const DriveEffect current_bias = {
    .name = "current-bias",
    .cause = "the current sensor has an offset",
    .equation = "I + I_0",
    .source = "catalogue of causes",
    .look_alikes = "torque-bias, joint-gravity, direction-asymmetry",
    .separates = "rows with the motor switched off, and loads of both signs",
    .columns = kColumns,
    .fill = fill,
};

}  // namespace simgap::drive_effects
