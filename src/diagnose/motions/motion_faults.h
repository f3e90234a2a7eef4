/// \file
/// What is wrong with recorded motions before any physics.
#pragma once

#include <vector>

#include "simgap/diagnose/diagnosis.h"
#include "simgap/measure/motion_set.h"

namespace simgap {

/// Shafts that stand while their set-points move and others follow, and channels that repeat one reading while
/// something moves: a cable off, a sensor that hangs, a capture that lost its markers. \param[out] faulty  shape
/// (motions)
std::vector<DataFault> findMotionFaults(const MotionSet& set, const PoseLayout& layout, std::vector<bool>& faulty);

}  // namespace simgap
