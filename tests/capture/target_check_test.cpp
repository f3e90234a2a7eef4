// What could be taken for what among targets of markers.
#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <random>

#include "simgap/capture/target_check.h"
#include "support/arms.h"
#include "support/capture_study.h"

namespace simgap::test {
namespace {

TEST(TargetCheck, TheStandardTargetsAreSound) {
  const TargetSetReport report = checkTargets(targetsOf(reality::standardTargets()), 0.2e-3);
  EXPECT_TRUE(report.sound());
  EXPECT_EQ(report.targets.size(), 3u);
  EXPECT_EQ(report.cross.size(), 3u);
}

TEST(TargetCheck, FindsWhatCanBeConfused) {
  const std::vector<Eigen::Vector3d> isosceles = {{0, 0, 0}, {0.1, 0, 0}, {0.05, 0.08, 0}};
  EXPECT_NEAR(closestLikeness(isosceles, isosceles, 3, true, false).rms, 0.0, 1e-12);  // turned over
  // A chiral target is not its own mirror image, but is that of its mirrored twin.
  const auto chiral = reality::standardTargets()[1].markers;
  auto twin = chiral;
  for (auto& m : twin) m.y() = -m.y();
  EXPECT_GT(closestLikeness(chiral, chiral, 5, false, true).rms, 5e-3);
  EXPECT_NEAR(closestLikeness(chiral, twin, 5, false, true).rms, 0.0, 1e-12);
  EXPECT_GT(closestLikeness(chiral, twin, 5, false, false).rms, 5e-3);
  // The same target, moved and renumbered.
  std::mt19937 random(5);
  std::vector<Eigen::Vector3d> moved;
  const Eigen::Quaterniond turn = randomRotation(random);
  for (const std::size_t i : {2, 0, 4, 1, 3}) moved.push_back(turn * chiral[i] + Eigen::Vector3d(1, 2, 3));
  const Likeness same = closestLikeness(chiral, moved, 5, false, false);
  EXPECT_NEAR(same.rms, 0.0, 1e-12);
  EXPECT_EQ(same.taken_for, (std::vector<int>{1, 3, 0, 4, 2}));
}

}  // namespace
}  // namespace simgap::test
