/// \file
/// The tree that the joints of an arm make of its bodies, from a body towards the base.
#pragma once

#include <vector>

#include "simgap/model/arm/arm.h"

namespace simgap {

/// The joint that a body hangs on; none: a base. \param body  index into the model's bodies
const Joint* jointCarrying(const ArmModel& model, int body);

/// Indices of the joints between a body and its base, the body's own first.
std::vector<int> jointsAbove(const ArmModel& model, int body);

}  // namespace simgap
