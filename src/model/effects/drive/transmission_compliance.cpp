/// \file
/// The cable or spring between motor and joint stretches under load, so that the joint lags behind the motor. Tested on
/// the angles, not on the effort (drive_equations::transmission).
#include "simgap/model/drive_effect.h"

namespace simgap::drive_effects {
namespace {

constexpr EffectColumn kColumns[] = {{.name = "compliance", .unit = "rad_Nm", .torque = false},
                                     {.name = "hardening", .unit = "rad_Nm2", .torque = false}};
constexpr Channel kNeeds[] = {Channel::kMotorAngle, Channel::kJointAngle};

void fill(std::span<const double> /*p*/, const DriveRows& rows, const DriveTerms& /*terms*/,
          const Eigen::ArrayXd& /*still*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = -rows.load;
  x.col(1) = rows.load * rows.load.abs();
}

}  // namespace

extern const DriveEffect transmission_compliance;
const DriveEffect transmission_compliance = {
    .name = "transmission-compliance",
    .kind = DriveKind::kTransmission,
    .cause = "the cable or spring between motor and joint stretches under load",
    .equation = "theta_M / r - theta = compliance tau_ext - hardening tau_ext |tau_ext|",
    .source = "003 fig. 15",
    .look_alikes = "an eccentric joint encoder, where the load follows the angle",
    .separates = "different loads at the same joint angle, with the motor held",
    .columns = kColumns,
    .needs = kNeeds,
    .fill = fill,
};

}  // namespace simgap::drive_effects
