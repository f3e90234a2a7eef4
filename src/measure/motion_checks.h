/// \file
/// Faults of a recorded motion that look like a bad model when nobody names them.
#pragma once

#include <span>
#include <string>

#include "simgap/measure/motion_set.h"

namespace simgap {

/// \throws DataError: the clocks of commands and joints share less than 0.3 s.
void refuseClocksApart(const RecordedMotion& motion);

/// Shafts follow their set-points. \param muscles  names, in the order of the motion's
/// \throws DataError: one is 180/pi times the other; they are of another motion, or of another muscle.
void refuseShaftsApart(const RecordedMotion& motion, std::span<const std::string> muscles);

}  // namespace simgap
