/// \file
/// An effort of any shape over one channel: what a cause has to explain more than that may only stand in for it. A
/// change at one moment does where the motion moves on to other places; a weight or a spring does where something else
/// goes with the joint's angle.
#pragma once

#include "log_hypotheses.h"

namespace simgap {

/// One of the two angles, or the index of a channel in ActuatorRows::context.
enum class ShapeOver { kMotorAngle = -2, kJointAngle = -1 };

/// The model with a broken line over a channel beside it, added to the effort. The log must have the channel.
Fitted besideShapeOver(const LogSearch& search, const Fitted& fitted, ShapeOver channel);

}  // namespace simgap
