/// \file
/// Motions that are foreseen, in the form in which a rig would have recorded them.
#pragma once

#include <string>

#include "simgap/intervene/motions/motion_separation.h"

namespace simgap {

/// The named candidate's own motion under commands, as if it had been recorded without noise.
/// \throws NumericsError: it blows up
RecordedMotion playedAsRecorded(const MotionEvidence& evidence, const ArmChanges& change, const PlannedMotion& planned);

/// Which limit the named candidate's motion exceeds, and by what; empty when none. \throws as playedAsRecorded
std::string beyondLimits(const MotionEvidence& evidence, const PlannedMotion& planned, const MotionLimits& limits);

}  // namespace simgap
