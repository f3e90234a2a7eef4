/// \file
/// Poses that no arm like the model can have come to, because a file means something else by its numbers.
#pragma once

#include "simgap/measure/pose_set.h"
#include "simgap/model/arm/arm.h"

namespace simgap {

/// Refuses shafts or joint angles in degrees where radians are announced, shafts and angles that the arm cannot reach,
/// and quaternions in the order x, y, z, w. Only a reading that the model contradicts by far, where the other one fits,
/// is called wrong.
/// \throws DataError with file, pose or column, what it looks like and what to do.
void refuseImplausiblePoses(const ArmModel& model, const PoseSet& set);

}  // namespace simgap
