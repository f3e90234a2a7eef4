/// \file
/// Which poses select causes, and which only measure what causes gain.
#pragma once

#include <cstddef>
#include <vector>

#include "simgap/measure/pose_set.h"

namespace simgap {

/// Poses of the selection and those held out, without the faulty ones.
struct Split {
  std::vector<Pose> selection, heldout, all;
};

/// Which poses only measure the gain, spread evenly over the order of recording. \param holdout  a fraction
std::vector<bool> chooseHeldout(std::size_t poses, double holdout);

/// \param heldout, faulty  shape (poses)
Split splitPoses(const PoseSet& set, const std::vector<bool>& heldout, const std::vector<bool>& faulty);

}  // namespace simgap
