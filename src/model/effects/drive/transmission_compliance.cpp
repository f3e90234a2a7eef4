/// \file
/// The cable or spring between motor and joint stretches under load, so that the joint lags behind the motor. Tested on
/// the angles, not on the effort (src/model/actuator/equations/transmission.cpp).
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::transmission_compliance {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "compliance", .unit = "rad_Nm", .torque = false},
                                     {.name = "hardening", .unit = "rad_Nm2", .torque = false}};
constexpr OptionalChannel kNeeds[] = {OptionalChannel::kMotorAngle, OptionalChannel::kJointAngle,
                                      OptionalChannel::kLoad};

void fill(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = -rows.load;
  x.col(1) = rows.load * rows.load.abs();
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "transmission-compliance",
    .kind = ActuatorKind::kTransmission,
    .cause = "the cable or spring between motor and joint stretches under load",
    .equation = "theta_M / r - theta = compliance tau_ext - hardening tau_ext |tau_ext|",
    .signature = "the difference of the angles follows the load and, where the cable stiffens, bends over it",
    .remarks =
        "it says nothing about the effort: the joint's angle is explained by the motor's, with a ratio, an offset and "
        "a lag between the encoders, and the gain is that of the angle; both parameters are negative where the load is "
        "logged with the other sign",
    .source = "003 fig. 15",
    .look_alikes = "an eccentric joint encoder, where the load follows the angle",
    .separates = "different loads at the same joint angle, with the motor held",
    .columns = kColumns,
    .needs = kNeeds,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::transmission_compliance
