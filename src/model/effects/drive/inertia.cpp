/// \file
/// A torque that accelerates what the model takes for massless: + J dw/dt.
#include "simgap/model/effects/actuator_effect.h"

namespace simgap::actuator_effects::inertia {
namespace {

constexpr EffectColumn kColumns[] = {{"J", "Nms2_rad", 0.0}};

void fill(std::span<const double> /*p*/, const ActuatorRows& rows, const ActuatorTerms& /*terms*/,
          const Eigen::ArrayXd& /*stribeck*/, Eigen::Ref<Eigen::ArrayXXd> x) {
  x.col(0) = rows.acceleration;
}

}  // namespace

extern const ActuatorEffect entry;
const ActuatorEffect entry = {
    .name = "inertia",
    .cause = "an inertia that the model leaves out has to be accelerated",
    .equation = "tau += J dw/dt",
    .signature = "a residual in phase with the acceleration",
    .source = "catalogue of causes",
    .look_alikes = "joint-gravity and channel-delay on sinusoids of one frequency",
    .separates = "the same angles at a slow and at a fast frequency",
    .columns = kColumns,
    .multiple_of = &ActuatorRows::acceleration,
    .fill = fill,
};

}  // namespace simgap::actuator_effects::inertia
