/// \file
/// Viscous friction that differs by the direction of motion: k_v (1 + a sign(w)) w = k_v w + k_a |w|.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::viscous_asymmetry {
namespace {

constexpr EffectColumn kColumns[] = {{"k_asym", "Nms_rad"}};

void fill(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = rows.speed.abs();
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "viscous-asymmetry",
    .cause = "viscous friction that differs by the direction of motion",
    .equation = "tau_fr += k_asym |w|",
    .signature = "the residual grows with speed, with the same sign in both directions",
    .source = "friction models of feed drives with direction-dependent viscous terms; seen on the EMPS axis",
    .look_alikes = "direction-asymmetry, current-bias, viscous-nonlinearity",
    .separates = "several constant speeds in both directions",
    .columns = kColumns,
    .on_robot = true,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::viscous_asymmetry
