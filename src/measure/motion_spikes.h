/// \file
/// Single readings of a recorded motion that no arm can have reached: a marker taken for another in one image, a lost
/// word on a bus.
#pragma once

#include <string>

#include "simgap/measure/motion_set.h"

namespace simgap {

/// Readings of joints and shafts that stand alone are replaced by what lies between their neighbours. Currents and
/// forces keep theirs: they may change within a row. \returns a sentence that counts them; empty where there is none
std::string repairMotionSpikes(RecordedMotion& motion, const PoseLayout& layout);

}  // namespace simgap
