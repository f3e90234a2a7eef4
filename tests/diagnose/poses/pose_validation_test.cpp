#include "diagnose/poses/pose_validation.h"

#include <gtest/gtest.h>

#include <numeric>

#include "pose_rig.h"

namespace simgap::test {
namespace {

TEST(PoseFolds, PredictEveryPoseAboutAsWellAsTheRightModelExpects) {
  PoseRig rig(21, {.poses = 40, .causes = 0});
  const PoseFolds folds(rig.set.poses);
  const CrossValidation result = folds.validate(rig.problem, {}, rig.plain.z(), {}, rig.plain.z());
  ASSERT_EQ(result.distances.size(), 40u);
  for (const double distance : result.distances) EXPECT_GT(distance, 0.0);
  const double sum = std::accumulate(result.distances.begin(), result.distances.end(), 0.0);
  EXPECT_GT(sum, 0.5 * result.expected);
  EXPECT_LT(sum, 1.5 * result.expected);
}

}  // namespace
}  // namespace simgap::test
