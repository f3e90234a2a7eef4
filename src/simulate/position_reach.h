/// \file
/// Joint positions that no arm like the model can have, because a file means something else by its numbers.
#pragma once

#include <functional>
#include <span>
#include <string>
#include <string_view>

#include "simgap/measure/motion_set.h"
#include "simgap/model/arm/arm.h"

namespace simgap {

/// Positions of all joints at many places of a file.
struct PlacedPositions {
  std::string file;
  std::size_t count;
  std::function<std::span<const JointPosition>(std::size_t)> joints;  ///< at a place, shape (joints)
  std::function<std::string(std::size_t)> place;                      ///< "pose p3", "motion lift, 2.5 s"
  double most_outside = 0.0;  ///< share of the places that may lie out of reach: single frames do where one is lost
  /// How far one may lie beyond a joint's limits, of what a hand-made model may have wrong: a quarter turn or 0.25 m.
  double tolerance = 1.0;
  std::string_view stem = {};  ///< before a joint's name in its column: "target_"
};

/// Refuses positions in degrees or millimetres where radians or metres are announced, with a turned sign, or otherwise
/// far beyond a joint's limits. \throws DataError with file, place and column, what it looks like and what to do
void refusePositionsOutOfReach(const ArmModel& model, const PlacedPositions& positions);

/// The same of what a motion set's files and starts say; a start has to lie next to the limits.
void refuseMotionsOutOfReach(const ArmModel& model, const MotionSet& set);

/// The same of one start, which has to agree with the couplings of joints, too.
void refuseStartOutOfReach(const ArmModel& model, std::span<const JointPosition> joints, const std::string& file,
                           const std::string& place);

}  // namespace simgap
