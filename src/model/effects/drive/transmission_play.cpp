/// \file
/// Play between motor and joint: the joint rests on one flank or the other, as the load presses it. Tested on the
/// angles, as transmission-compliance, for which it passes where it is not asked for.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::transmission_play {
namespace {

constexpr double kUndecided = 0.02;  // of the largest load: with less the sensor does not say which flank it is

constexpr EffectColumn kColumns[] = {{.name = "play", .unit = "rad", .torque = false}};
constexpr OptionalChannel kNeeds[] = {OptionalChannel::kMotorAngle, OptionalChannel::kJointAngle,
                                      OptionalChannel::kLoad};

void fill(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = -0.5 * (rows.load / (kUndecided * rows.top_load)).max(-1.0).min(1.0);
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "transmission-play",
    .kind = ActuatorKind::kTransmission,
    .cause = "there is play between motor and joint, which the load takes up on one side or the other",
    .equation = "theta_M / r - theta = play / 2 sign(tau_ext)",
    .signature = "the difference of the angles steps where the load changes its sign, and stays wherever it is large",
    .remarks =
        "one of the two is named: what is left beside a cable that stretches is the shape of its law; as there, "
        "negative "
        "where the load is logged with the other sign",
    .source = "Nordin & Gutman 2002",
    .look_alikes = "transmission-compliance",
    .separates = "loads of several sizes in both directions, with the motor held",
    .columns = kColumns,
    .needs = kNeeds,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::transmission_play
