/// \file
/// What is outside the catalogue: friction, or the effort itself, that depends on a logged channel u, or on the product
/// of two, in a way that no named cause explains. It competes with the named causes so that none of them is blamed for
/// it; what it wins is reported as `unexplained` with the channel's name.
#pragma once

#include "simgap/model/effects/actuator_effect.h"

namespace simgap {

/// (1 + a u + b u^2) on the friction and + c u + d u^2 on the effort; u: a channel of ActuatorRows::context, or the
/// product of two when `second` is not negative.
extern const ActuatorEffect kChannelDependence;

}  // namespace simgap
