/// \file
/// Single readings of a recorded motion that no arm can have reached: a marker taken for another in one image, a lost
/// word on a bus.
#pragma once

#include <string>
#include <vector>

#include "simgap/measure/motion_set.h"

namespace simgap {

/// What was replaced in a motion.
struct LoneReadings {
  std::size_t count = 0;
  std::string where;  ///< "wave: 1 of 240 of elbow, 2 of 300 of the shaft of biceps"
};

/// Readings of joints and shafts that stand alone are replaced by what lies between their neighbours. Currents and
/// forces keep theirs: they may change within a row.
LoneReadings repairMotionSpikes(RecordedMotion& motion, const PoseLayout& layout);

/// A sentence for the motions of a set; empty where nothing was replaced.
std::string sayLoneReadings(const std::vector<LoneReadings>& motions);

}  // namespace simgap
