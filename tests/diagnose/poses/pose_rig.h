/// \file
/// A drawn arm with its fit without causes, for the pieces of a diagnosis.
#pragma once

#include "diagnose/poses/pose_fit.h"
#include "support/drawn_poses.h"

namespace simgap::test {

struct PoseRig {
  reality::PoseDraw draw;
  PoseProblem problem;
  PoseSet set;
  PoseFit plain;

  PoseRig(std::uint64_t seed, const reality::PoseDrawOptions& options)
      : draw(reality::drawPoses(seed, options)),
        problem{modelOf(draw), paperConfig().parameters, paperConfig().noise, 0},
        set(posesOf(draw, draw.poses)),
        plain(problem, set.poses, {}) {
    plain.search(2, 0, 1);
  }
};

}  // namespace simgap::test
