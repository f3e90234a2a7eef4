/// \file
/// Where an arm was measured and where it was simulated, as tables: what the page's view in three
/// dimensions is made from.
#pragma once

#include <span>
#include <string>
#include <vector>

#include "simgap/core/run_directory.h"
#include "simgap/measure/pose_set.h"
#include "simgap/simulate/pose_protocol.h"

namespace simgap {

/// A model's replay of a pose set.
struct ReplayedSet {
  std::string set;    ///< "validation"
  std::string state;  ///< "before", "after", "simulated"
  const ArmModel& model;
  const PoseSet& poses;
  const std::vector<PoseOutcome>& outcomes;
};

/// Writes, in metres and the world's frame,
///   arm_parts.csv    the shapes of the bodies, in their own frames; joints as spheres
///   arm_bodies.csv   the bodies' frames per set, pose and state; "measured" by the kinematics of the set's last model
///   arm_muscles.csv  the points of every muscle's path, and its tension where the arm rests [N]
/// Poses that did not come to rest have no rows.
void writeArmGeometry(std::span<const ReplayedSet> replays, const RunDirectory& directory);

}  // namespace simgap
