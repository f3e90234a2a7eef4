/// \file
/// Fitted friction models as what controllers and simulators calculate with.
#pragma once

#include <span>

#include "simgap/model/actuator/feed_forward.h"
#include "simgap/model/actuator/fitted_model.h"
#include "simgap/model/friction/friction_law.h"

namespace simgap {

/// Fitted parameters of a law as its closed form.
DriveFeedForward feedForward(const FrictionLaw& law, std::span<const Estimate> estimates);

/// A drive whose current [A] was fitted to its load [N m] and the motor's velocity [rad/s].
/// \throws ConfigError: another quantity or direction, or causes that were added to the law
DriveFeedForward feedForward(const FittedModel& model);

}  // namespace simgap
